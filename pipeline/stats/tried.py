"""Viewpoints that were tried one at a time: their scores, with the intervals of a scene's table of views."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.stats.blocks import mean_half_width, two_way


@dataclass(frozen=True)
class Spot:
    """Where the camera stood in an experiment: the scene, and pan and tilt in degrees."""

    experiment: str
    scene: str
    theta_deg: float
    phi_deg: float


@dataclass(frozen=True)
class Tried:
    """What was reached from there.

    Attributes:
        spot: the viewpoint.
        repeats: how many trainings.
        return_mean: paper eq. (2), m.
        score_mean, score_low, score_high: normalised (0 blind, 1 expert); no interval with one repeat.
    """

    spot: Spot
    repeats: int
    return_mean: float
    score_mean: float
    score_low: float | None
    score_high: float | None


def tried(runs: Mapping[Spot, Sequence[tuple[float, float]]], confidence: float) -> list[Tried]:
    """One row per viewpoint, in the given order.

    Views of a scene with equally many repeats are one table (view, repeat), since repeat r has the same
    draws in all of them; its error is theirs together.

    Args:
        runs: of each viewpoint its repeats' returns and scores, repeat by repeat.
        confidence: of the intervals.
    """
    tables: dict[tuple[str, int], list[Spot]] = {}
    for spot, repeats in runs.items():
        tables.setdefault((spot.scene, len(repeats)), []).append(spot)
    found = {}
    for spots in tables.values():
        values = np.array([runs[spot] for spot in spots])  # (view, repeat, return and score)
        half = mean_half_width(two_way(values[..., 1]), confidence)
        for spot, (returned, score) in zip(spots, values.mean(axis=1), strict=True):
            low, high = (None, None) if half is None else (float(score - half), float(score + half))
            found[spot] = Tried(spot, values.shape[1], float(returned), float(score), low, high)
    return [found[spot] for spot in runs]
