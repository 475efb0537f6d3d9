"""A study's own trials: every pair of views of every task, by time and by distance.

What leaves this module tells of no single person: with fewer people than :data:`LEAST_PEOPLE` there are
counts only, since a mean and a spread of so few give their values away.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from pipeline.stats.agreement import Row, View
from pipeline.stats.judges import holm
from pipeline.stats.power import NextStudy, next_study
from pipeline.stats.two_views import SignedRanks, TTest, paired, signed_ranks, two_sample

LEAST_PEOPLE = 5


@dataclass(frozen=True)
class Measured:
    """People's means under one view, by participant, in the measure's unit; less is better."""

    scene: str
    view: str
    angles: View
    measure: str
    unit: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class Tested:
    """Two views of a scene by one measure; differences are the first less the second.

    Attributes:
        scene, measure, unit: what. first, second: the views' names, and their angles in degrees.
        people_first, people_second, pairs: who has trials that count under either, and under both.
        first_mean, second_mean, first_sd, second_sd: over people, in the unit.
        two_sample, paired, signed_ranks: the tests. …_holm: their p-values, each kind of test corrected over
            all pairs of views and measures.
        next: people for the paired test to find the difference.
    """

    scene: str
    measure: str
    unit: str
    first: str
    second: str
    first_theta: float
    first_phi: float
    second_theta: float
    second_phi: float
    people_first: int
    people_second: int
    pairs: int
    first_mean: float | None = None
    second_mean: float | None = None
    first_sd: float | None = None
    second_sd: float | None = None
    two_sample: TTest | None = None
    two_sample_holm: float | None = None
    paired: TTest | None = None
    paired_holm: float | None = None
    signed_ranks: SignedRanks | None = None
    signed_ranks_holm: float | None = None
    next: NextStudy | None = None


def view_pairs(measured: Sequence[Measured], order: Sequence[tuple[str, View, View]]) -> list[list[Measured]]:
    """All pairs of views with the same scene and measure; in the order of ``order`` where that names them."""
    found = []
    for one, other in combinations(measured, 2):
        if (one.scene, one.measure) == (other.scene, other.measure):
            turned = (one.scene, other.angles, one.angles) in order
            found.append([other, one] if turned else [one, other])
    return found


def compared_pairs(
    pairs: Sequence[Sequence[Measured]], alpha: float, power: float, synthetic: bool
) -> list[Tested]:
    """All tests of all pairs, Holm's correction over the family of each kind of test, and the next study."""
    tested = [_tested(first, second, alpha, least_people(synthetic)) for first, second in pairs]
    samples, in_pairs, ranks = (
        _adjusted([row.two_sample for row in tested]),
        _adjusted([row.paired for row in tested]),
        _adjusted([row.signed_ranks for row in tested]),
    )
    return [
        replace(
            _with_next(row, alpha / len(tested), power),
            two_sample_holm=samples[i],
            paired_holm=in_pairs[i],
            signed_ranks_holm=ranks[i],
        )
        for i, row in enumerate(tested)
    ]


def least_people(synthetic: bool) -> int:
    """How many there must be for more than counts to be told; the scripted operator is nobody."""
    return 1 if synthetic else LEAST_PEOPLE


def _adjusted(tests: Sequence[TTest | SignedRanks | None]) -> list[float | None]:
    """Holm's p-values of the tests that there are."""
    adjusted = iter(holm([test.p for test in tests if test is not None]))
    return [None if test is None else next(adjusted) for test in tests]


def rows(tested: Sequence[Tested], source: str) -> list[Row]:
    """The same in the layout of the published table."""
    return [
        Row(
            source=source,
            scene=t.scene,
            measure=t.measure,
            unit=t.unit,
            first_theta=t.first_theta,
            first_phi=t.first_phi,
            second_theta=t.second_theta,
            second_phi=t.second_phi,
            people=max(t.people_first, t.people_second),
            first=t.first_mean,
            second=t.second_mean,
            p=t.two_sample.p if t.two_sample else None,
        )
        for t in tested
    ]


def _tested(first: Measured, second: Measured, alpha: float, least: int) -> Tested:
    both = sorted(first.values.keys() & second.values.keys())
    found = Tested(
        scene=first.scene, measure=first.measure, unit=first.unit, first=first.view, second=second.view,
        first_theta=first.angles[0], first_phi=first.angles[1], second_theta=second.angles[0],
        second_phi=second.angles[1], people_first=len(first.values), people_second=len(second.values),
        pairs=len(both),
    )  # fmt: skip
    one, other = (np.array(list(m.values.values())) for m in (first, second))
    if min(len(one), len(other)) >= least:
        found = replace(
            found, first_mean=float(one.mean()), second_mean=float(other.mean()), first_sd=_sd(one),
            second_sd=_sd(other), two_sample=two_sample(one, other, alpha),
        )  # fmt: skip
    if len(both) < least:
        return found
    one, other = (np.array([m.values[name] for name in both]) for m in (first, second))
    ranks = signed_ranks(one, other, alpha)
    return replace(found, paired=paired(one, other, alpha), signed_ranks=ranks)


def _sd(values: np.ndarray) -> float | None:
    return float(values.std(ddof=1)) if len(values) > 1 else None


def _with_next(row: Tested, level: float, power: float) -> Tested:
    t = row.paired
    if t is None:
        return row
    found = next_study(t.effect, t.effect_low, t.effect_high, row.pairs, level, power)
    return replace(row, next=found)
