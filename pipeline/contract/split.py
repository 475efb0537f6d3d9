"""The one split into training and held-out episodes, for networks, probes and the controller's start."""

from __future__ import annotations

import numpy as np

from pipeline.contract.errors import BelvedereError


def split_episodes(episodes: int, heldout_share: float) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the training and of the held-out episodes of a repeat.

    Episodes are drawn independently, so the last ones serve as well as any.

    Returns:
        ``(training, heldout)``, integer arrays, both non-empty.

    Raises:
        BelvedereError: fewer than two episodes.
    """
    if episodes < 2:
        raise BelvedereError(
            f"rollouts hold {episodes} episode(s); at least 2 are needed to hold one out "
            "(budgets.*.rollouts.episodes in params.yaml)."
        )
    heldout = min(max(1, round(episodes * heldout_share)), episodes - 1)
    indices = np.arange(episodes)
    return indices[:-heldout], indices[-heldout:]
