"""What a ranking says of judges and of the paper's findings, as the report reads it."""

from __future__ import annotations

from pipeline.reporting.tables import Table


class FTest(Table):
    """An F test: numerator and denominator degrees of freedom, statistic and p-value."""

    df: float
    df_error: float
    f: float
    p: float


class Step(Table):
    """Score at one level of a factor less that at another, with its interval."""

    factor: str
    first_deg: float
    second_deg: float
    difference: float
    low: float
    high: float


class Effect(Step):
    """Over all levels of the other factor; the 90 % interval is held against the margin."""

    equivalence_low: float
    equivalence_high: float
    se: float
    word: str


class EffectByJudge(Step):
    """How much more a step changes the first judge's score; ``p`` is adjusted by Holm's method."""

    p: float


class Factorial(Table):
    """Effects of pan and tilt of one judge."""

    margin: float
    tests: dict[str, FTest]
    effects: list[Effect]


class DqnView(Table):
    """What the deep Q-networks of one view reached."""

    return_mean: float
    score_mean: float
    score_of_restricted_mean: float


class Dqn(Table):
    """What the deep Q-networks of a scene reached."""

    repeats: int
    viewpoints: dict[str, DqnView]
    score_half_width: float | None
    restricted_expert_return: float
    factorial: Factorial | None


class Judges(Table):
    """Whether what a view gives depends on the judge."""

    test: FTest | None
    effects: list[EffectByJudge]


class Held(Table):
    """A finding of the paper beside ours, in score; ``direction`` and ``size`` are null where not told."""

    section: str
    scene: str
    judge: str
    factor: str
    first_deg: float | None
    second_deg: float | None
    finding: str
    difference: float | None
    low: float | None
    high: float | None
    direction: str | None
    size: str | None
    outcome: str
