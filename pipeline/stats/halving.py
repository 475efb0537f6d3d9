"""A search over many views: halving by repeats in common blocks, then a race of finalists on fresh repeats.

Round r gives every view still in it its r-th repeat, with the same draws for all, and keeps the better half
by the mean over its repeats, until so many are left as shall be finalists. Nothing is assumed of how scores
vary over the sphere. What is said of the finalists comes from repeats made after they were chosen: those by
which they were chosen would flatter them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.stats.race import Rules
from pipeline.stats.replay import Race, replay


@dataclass(frozen=True)
class Round:
    """A round of halving.

    Attributes:
        repeats: that each view in it has.
        entered: the views in it, best first.
        kept: those that stay, best first.
    """

    repeats: int
    entered: list[int]
    kept: list[int]


@dataclass(frozen=True)
class Halving:
    """A search so far.

    Attributes:
        rounds: that are complete.
        active: the views that are left, best first.
        finalists: how many there shall be.
        needed: of views whose repeats do not suffice, how many they need.
    """

    rounds: list[Round]
    active: list[int]
    finalists: int
    needed: dict[int, int]

    @property
    def done(self) -> bool:
        """Whether the finalists are known."""
        return not self.needed and len(self.active) <= self.finalists


def halve(values: Sequence[np.ndarray], finalists: int) -> Halving:
    """Runs the rounds for which there are repeats.

    Args:
        values: of each view (repeat,) its repeats from the first on; there may be none yet.
        finalists: how many views stay in the end; where there are no more than that, nothing is halved.
    """
    active, rounds = list(range(len(values))), list[Round]()
    while len(active) > finalists:
        repeats = len(rounds) + 1
        lacking = {view: repeats for view in active if len(values[view]) < repeats}
        if lacking:
            return Halving(rounds, active, finalists, lacking)
        ordered = sorted(active, key=lambda view: -float(values[view][:repeats].mean()))
        active = ordered[: max(finalists, -(-len(ordered) // 2))]
        rounds.append(Round(repeats, ordered, list(active)))
    return Halving(rounds, active, finalists, {})


def least_trainings(views: int, finalists: int, first: int) -> int:
    """Trainings up to the first look at the finalists' race, where the judge sees from every view.

    Args:
        views: that are searched.
        finalists: how many of them shall be left.
        first: fresh repeats of each finalist.
    """
    made = repeats = 0
    active = views
    while active > finalists:
        repeats, made = repeats + 1, made + active
        active = max(finalists, -(-active // 2))
    return made + active * first


def final(values: Sequence[np.ndarray], halving: Halving, rules: Rules) -> tuple[Race | None, dict[int, int]]:
    """The finalists' race on the repeats after those of the halving, and what its first look lacks.

    Views of the race are places in ``halving.active``. ``None`` before the first look.
    """
    spent = len(halving.rounds)
    fresh = [values[view][spent:] for view in halving.active]
    lacking = {
        view: spent + rules.first
        for view, own in zip(halving.active, fresh, strict=True)
        if len(own) < rules.first
    }
    return (None, lacking) if lacking else (replay(fresh, rules), {})
