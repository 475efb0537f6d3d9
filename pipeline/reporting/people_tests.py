"""Tests of two views and the next study as stage `people` wrote them, checked as they are read."""

from __future__ import annotations

from pipeline.reporting.tables import Table


class TTest(Table):
    """See :class:`pipeline.stats.two_views.TTest`."""

    difference: float
    low: float
    high: float
    t: float
    df: float
    p: float
    effect: float
    effect_low: float
    effect_high: float


class SignedRanks(Table):
    """See :class:`pipeline.stats.two_views.SignedRanks`."""

    w: float
    p: float
    shift: float
    low: float | None
    high: float | None
    effect: float


class NextStudy(Table):
    """See :class:`pipeline.stats.power.NextStudy`."""

    people: int | None
    more: int | None
    cautious: int | None
    level: float


class Tested(Table):
    """See :class:`pipeline.stats.people.Tested`."""

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
    first_mean: float | None
    second_mean: float | None
    first_sd: float | None
    second_sd: float | None
    two_sample: TTest | None
    two_sample_holm: float | None
    paired: TTest | None
    paired_holm: float | None
    signed_ranks: SignedRanks | None
    signed_ranks_holm: float | None
    next: NextStudy | None
