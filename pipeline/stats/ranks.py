"""Viewpoints in order, each with its intervals, its distance to the leader and its place in the race."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.stats.blocks import own_interval
from pipeline.stats.branches import Results
from pipeline.stats.replay import Race

LEADER = "leader"
AS_GOOD = "may be as good"
NOT_BEST = "not the best"
UNSEEING = "cannot see"


@dataclass(frozen=True)
class Ranked:
    """One viewpoint's line of the table; bounds are ``None`` where nothing tells the error.

    Attributes:
        key: the branch.
        rank: 1 for the leader; views at which the judge cannot see come last.
        theta_deg, phi_deg: pan and tilt.
        repeats: number of independent trainings.
        return_mean, return_low, return_high: mean return with the t interval of its own repeats (m).
        score_mean, score_low, score_high: the same in score (0 target-blind, 1 expert).
        behind_leader, behind_low, behind_high: the leader's score less its own over common repeats, with the
            race's bounds, which hold together and at every look; ``None`` for the leader and out of the race.
        state: ``leader``, ``may be as good``, ``not the best`` or ``cannot see``.
        out_after: repeats after which it was eliminated.
        failed: how many trainings came out at or below target-blind.
        misses: what the world model's latent lacks (:class:`pipeline.storage.sight.Sight`).
        probe_m, guess_m: errors by which that is told.
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
    behind_leader: float | None
    behind_low: float | None
    behind_high: float | None
    state: str
    out_after: int | None
    failed: int
    misses: list[str]
    probe_m: float
    guess_m: float
    duplicates: list[str]


def rank(results: Results, race: Race | None, confidence: float) -> list[Ranked]:
    """The scene's table: leader, what may be as good, what is not the best, what is not in the race.

    Args:
        results: of the scene.
        race: of the views at which the judge sees, in their order; ``None`` where there is none.
        confidence: of a view's own intervals.
    """
    ordered = _order(results.seen, race)
    unseen = [key for key in results.branches if key not in results.seen]
    ordered += sorted(unseen, key=lambda key: -float(results.returns[key].mean()))
    return [_row(key, place, results, race, confidence) for place, key in enumerate(ordered, start=1)]


def _order(keys: Sequence[str], race: Race | None) -> list[str]:
    if race is None:
        return []
    behind = {view: _behind(race, view) for view in range(len(keys))}
    return [keys[view] for view in sorted(behind, key=lambda view: (view in race.out, behind[view]))]


def _behind(race: Race, view: int) -> float:
    """Over the latest repeats common to the leader and this view; the leader itself comes first."""
    if view == race.leader:
        return -np.inf
    means = race.shared(race.leader, view).means
    return float(means[race.leader] - means[view])


def _row(key: str, place: int, results: Results, race: Race | None, confidence: float) -> Ranked:
    branch, sight, scores = results.branches[key], results.sight[key], results.scores[key]
    behind, state, out_after = _in_race(key, results, race, confidence)
    return Ranked(
        key,
        place,
        branch.theta,
        branch.phi,
        len(scores),
        *own_interval(results.returns[key], confidence),
        *own_interval(scores, confidence),
        *behind,
        state=state,
        out_after=out_after,
        failed=int((scores <= 0).sum()),
        misses=sight.misses,
        probe_m=sight.probe_m,
        guess_m=sight.guess_m,
        duplicates=results.duplicates[key],
    )


def _in_race(
    key: str, results: Results, race: Race | None, confidence: float
) -> tuple[tuple[float | None, float | None, float | None], str, int | None]:
    """How far behind the leader with bounds, where it stands, and when it went out."""
    nothing = (None, None, None)
    if race is None or key not in results.seen:
        return nothing, UNSEEING, None
    view = results.seen.index(key)
    if view == race.leader:
        return nothing, LEADER, None
    gap = race.between(race.leader, view, confidence)
    behind = (gap.difference, gap.difference - gap.half_width, gap.difference + gap.half_width)
    out_after = race.out.get(view)
    return behind, AS_GOOD if out_after is None else NOT_BEST, out_after
