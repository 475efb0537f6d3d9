"""A scene's ranking as the report reads it: the answer, the race that led to it, and what stands beside."""

from __future__ import annotations

from typing import Any, Literal

from pipeline.reporting.judge_tables import Dqn, Factorial, Held, Judges
from pipeline.reporting.tables import Table

State = Literal["leader", "may be as good", "not the best", "cannot see"]
Kind = Literal["alone", "tolerance", "either", "ended", "open", "cannot see", "not above blind"]


class Answer(Table):
    """Where to put the camera.

    Attributes:
        kind: which sort of answer it is.
        keys: the leader first, then the views that may be as good; none where nothing was found.
        within: the leader is the best or within this of it (score).
        sure: whether the level of confidence may be stated.
        forecast_trainings: about how many more would bring ``within`` down to the tolerance.
        sentence, progress: for people, at the end and on the way.
    """

    kind: Kind
    keys: list[str]
    within: float | None
    sure: bool
    forecast_trainings: int | None
    sentence: str
    progress: str


class Look(Table):
    """The race after so many repeats."""

    repeats: int
    leader: str | None
    within: float | None
    active: list[str]


class Race(Table):
    """The race so far: ``out`` has the repeats after which a view was eliminated; leads in score."""

    open: bool
    common: int
    active: list[str]
    out: dict[str, int]
    leader: str | None
    lead_low: float | None
    lead_high: float | None
    looks: list[Look]


class RankedView(Table):
    """One viewpoint's row; returns in metres, scores 0 = target-blind and 1 = expert, probes in metres."""

    rank: int
    theta_deg: float
    phi_deg: float
    repeats: int
    score_mean: float
    score_low: float | None
    score_high: float | None
    return_mean: float
    return_low: float | None
    return_high: float | None
    behind_leader: float | None
    behind_low: float | None
    behind_high: float | None
    state: State
    out_after: int | None
    failed: int
    misses: list[str]
    probe_m: float
    guess_m: float
    duplicates: list[str]


class Pair(Table):
    """One view less another over their common repeats (score)."""

    first: str
    second: str
    repeats: int
    difference: float
    low: float | None
    high: float | None


class Spread(Table):
    """The spread of one repeat's score once what the repeat's views share is taken out."""

    sd: float | None
    df: float | None


class Baseline(Table):
    """A cheap number per view, and how its order agrees with that of the returns."""

    name: str
    stage: str
    values: dict[str, float]
    tau: float | None
    p: float | None
    same_sign: bool | None


class Ranking(Table):
    """One scene's ranking, ``reports/rankings/{scene}.json``."""

    scene: str
    confidence: float
    tolerance: float
    unit_m: float
    blind_m: float
    first: int
    most: int
    answer: Answer
    race: Race
    viewpoints: dict[str, RankedView]
    pairs: list[Pair]
    spread: Spread | None
    factorial: Factorial | None
    dqn: Dqn | None
    judges: Judges | None
    claims: list[Held]
    baselines: list[Baseline]
    provenance: dict[str, Any]
