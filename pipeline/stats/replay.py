"""A scene's race, replayed from the repeats at hand: where it stands, and what it says of any two views."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import stats

from pipeline.stats.race import Look, Rules, look, no_error, with_repeat

State = Literal["alone", "tolerance", "ended", "open"]


@dataclass(frozen=True)
class Between:
    """One view less another over their common repeats.

    Attributes:
        repeats: how many they have in common, of those that the race looked at.
        difference: of their means.
        half_width: w_ij of the race: one-sided, simultaneous, at every look.
        low, high: the t interval of this difference alone.
    """

    repeats: int
    difference: float
    half_width: float
    low: float
    high: float


@dataclass(frozen=True)
class Race:
    """A race so far.

    Attributes:
        rules: of it.
        looks: one for each number of repeats from the first look on.
        state: ``alone``, ``tolerance`` (U is small enough), ``ended`` (all repeats are spent) or ``open``.
        out: of each eliminated view (an index) the repeats after which.
    """

    rules: Rules
    looks: list[Look]
    state: State
    out: dict[int, int]

    @property
    def last(self) -> Look:
        """The latest look."""
        return self.looks[-1]

    @property
    def leader(self) -> int:
        """The view that leads."""
        return int(self.last.leader)

    @property
    def active(self) -> list[int]:
        """The views that are left, best first."""
        left = [int(view) for view in np.flatnonzero(self.last.active)]
        return sorted(left, key=lambda view: -float(self.last.means[view]))

    def shared(self, first: int, second: int) -> Look:
        """The latest look that compared both."""
        return next(one for one in reversed(self.looks) if one.entered[first] and one.entered[second])

    def between(self, first: int, second: int, confidence: float) -> Between:
        """What is known of a difference; ``confidence`` is of its own t interval."""
        at = self.shared(first, second)
        difference = float(at.means[first] - at.means[second])
        quantile = float(stats.t.ppf((1 + confidence) / 2, float(at.error.df)))
        own = quantile * float(at.variances[first, second] / at.repeats) ** 0.5
        half = float(at.half_widths[first, second])
        return Between(at.repeats, difference, half, difference - own, difference + own)

    def lead(self) -> tuple[float, float | None]:
        """By how much the leader is ahead of the next, and at most; ``None`` where it is the only view.

        The upper bound holds at every look, so each view is taken where it was last compared.
        """
        others = [view for view in range(len(self.last.entered)) if view != self.leader]
        if not others:
            return 0.0, None
        at = {view: self.shared(self.leader, view) for view in others}
        ahead = {view: float(one.means[self.leader] - one.means[view]) for view, one in at.items()}
        most = min(ahead[view] + float(at[view].half_widths[self.leader, view]) for view in others)
        return min(ahead.values()), max(0.0, most)

    def forecast(self) -> int:
        """About how many more trainings bring U to the tolerance, were the means as they are.

        n ≈ v c² / (tolerance + lead)² repeats for each rival, of which the most count, times the views left.
        """
        at, a = self.last, self.leader
        rivals = [view for view in self.active if view != a]
        needed = [
            float(at.half_widths[a, j]) ** 2
            * at.repeats
            / (self.rules.tolerance + float(at.means[a] - at.means[j])) ** 2
            for j in rivals
        ]
        more = max(1, int(np.ceil(max(needed, default=0.0))) - at.repeats)
        return more * (len(rivals) + 1)


def replay(values: Sequence[np.ndarray], rules: Rules) -> Race:
    """Runs a race on what there is; repeats that it does not need are not looked at.

    Args:
        values: of each view (repeat,), its repeats from the first on; at least ``rules.first``.
        rules: of the race.
    """
    views = len(values)
    active, error = np.ones(views, dtype=bool), no_error()
    looks: list[Look] = []
    out: dict[int, int] = {}
    for repeats in range(1, rules.most + 1):
        if any(active[view] and len(own) < repeats for view, own in enumerate(values)):
            return Race(rules, looks, "open", out)
        seen = np.full((views, repeats), np.nan)
        for view in np.flatnonzero(active):
            seen[view] = values[int(view)][:repeats]
        error = with_repeat(error, seen, active)
        if repeats < rules.first:
            continue
        looks.append(look(seen, active, error, views, rules.probability))
        out |= {int(view): repeats for view in np.flatnonzero(active & ~looks[-1].active)}
        active = looks[-1].active
        if active.sum() == 1:
            return Race(rules, looks, "alone", out)
        if looks[-1].within <= rules.tolerance:
            return Race(rules, looks, "tolerance", out)
    return Race(rules, looks, "ended", out)
