"""Random actions that hang together in time, so that episodes cover the workspace."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from pipeline.contract.params import Section


class ExplorationParams(Section):
    """An Ornstein-Uhlenbeck process per axis.

    Attributes:
        correlation: of an action with the one a frame before.
        deviation: stationary standard deviation, shares of the largest displacement.
    """

    correlation: Annotated[float, Field(ge=0, lt=1)]
    deviation: Annotated[float, Field(gt=0)]


def correlated_actions(
    shape: tuple[int, int, int], process: ExplorationParams, rng: np.random.Generator
) -> np.ndarray:
    """Actions (episode, frame, axis) in [-1, 1], float32, from the stationary process, clipped."""
    noise = rng.standard_normal(shape)
    fresh = np.sqrt(1.0 - process.correlation**2)
    actions = np.empty(shape)
    actions[:, 0] = noise[:, 0]
    for t in range(1, shape[1]):
        actions[:, t] = process.correlation * actions[:, t - 1] + fresh * noise[:, t]
    return np.clip(process.deviation * actions, -1.0, 1.0).astype(np.float32)
