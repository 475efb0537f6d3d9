"""Viewpoints in order of their mean return, each with intervals and a verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.stats.best import chance_of_best
from pipeline.stats.blocks import TwoWay, difference_half_width, mean_half_width, two_way
from pipeline.stats.branches import Results

BEST = "best"
NOT_SEPARATED = "not separated"
WORSE = "worse"
NOT_ABOVE_BLIND = "not above blind"

Estimate = tuple[float, float | None, float | None]  # value, low, high


@dataclass(frozen=True)
class Ranked:
    """One viewpoint's line of the table; bounds are ``None`` where nothing tells the error.

    Attributes:
        key: the branch.
        rank: 1 for the highest mean return.
        theta_deg, phi_deg: pan and tilt.
        repeats: number of independent trainings.
        return_mean, return_low, return_high: mean return with its t interval.
        score_mean, score_low, score_high: the same of the normalised score (0 blind, 1 expert).
        difference_to_best, difference_low, difference_high: mean return less the best view's, with
            Tukey's interval; ``None`` for the best view itself.
        best_chance: how likely this view is the best (:mod:`pipeline.stats.best`).
        verdict: ``best``, ``not separated``, ``worse`` or ``not above blind``.
        duplicates: other branches with the same viewpoint.
    """

    key: str
    rank: int
    theta_deg: float
    phi_deg: float
    repeats: int
    return_mean: float
    return_low: float | None
    return_high: float | None
    score_mean: float
    score_low: float | None
    score_high: float | None
    difference_to_best: float | None
    difference_low: float | None
    difference_high: float | None
    best_chance: float | None
    verdict: str
    duplicates: list[str]

    @property
    def tied(self) -> bool:
        """Whether it is the best view or nothing separates it from the best view."""
        return self.difference_high is None or self.difference_high >= 0

    @property
    def above_blind(self) -> bool:
        """Whether the score's interval lies above 0."""
        return self.score_low is not None and self.score_low > 0


def rank(results: Results, confidence: float) -> tuple[list[Ranked], TwoWay]:
    """The scene's table, best first, and the fit of the returns that its errors come from."""
    fit = two_way(results.returns)
    returns = _around(fit.means, mean_half_width(fit, confidence))
    scores_fit = two_way(results.scores)
    scores = _around(scores_fit.means, mean_half_width(scores_fit, confidence))
    order = [int(index) for index in np.argsort(-fit.means, kind="stable")]
    gaps = _around(fit.means - fit.means[order[0]], difference_half_width(fit, confidence))
    chances: Sequence[float | None] = chance_of_best(fit) or [None] * len(order)
    table = []
    for place, index in enumerate(order, start=1):
        key, branch = list(results.branches.items())[index]
        gap: tuple[float | None, float | None, float | None] = gaps[index] if place > 1 else (None,) * 3
        table.append(
            Ranked(
                key,
                place,
                branch.theta,
                branch.phi,
                fit.repeats,
                *returns[index],
                *scores[index],
                *gap,
                best_chance=chances[index],
                verdict=NOT_SEPARATED,
                duplicates=results.duplicates[key],
            )
        )
    return [replace(row, verdict=_verdict(row, table)) for row in table], fit


def _verdict(row: Ranked, table: list[Ranked]) -> str:
    if row.score_low is not None and not row.above_blind:
        return NOT_ABOVE_BLIND
    if not row.tied:
        return WORSE
    alone = len(table) > 1 and not any(other.tied for other in table[1:])
    return BEST if row.rank == 1 and alone else NOT_SEPARATED


def _around(values: np.ndarray, half_width: float | None) -> list[Estimate]:
    if half_width is None:
        return [(value, None, None) for value in values.tolist()]
    return [(value, value - half_width, value + half_width) for value in values.tolist()]
