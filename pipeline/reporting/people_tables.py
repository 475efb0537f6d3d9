"""What stage `people` wrote, checked as it is read: aggregates, and the points that plots draw."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import polars as pl

from pipeline.reporting.people_tests import Tested
from pipeline.reporting.tables import Table
from pipeline.storage.tables import read_model
from pipeline.study.means import COURSE, MEANS, read_points


class Compared(Table):
    """People's means under two views beside ours.

    Attributes:
        source, people: who measured, and how many.
        first, second: people's means under either view (θ, φ in degrees), lower is better; null for too few.
        p, p_holm: of people's difference, raw and adjusted.
        people_advantage: by how much the first view is better for people, share of the second's mean.
        ours, low, high: the first view's score less the second's; null where one was not ranked.
        same_sign: whether both prefer the same view.
        settled: whether our interval lies on one side.
    """

    source: str
    scene: str
    measure: str
    unit: str
    first_theta: float
    first_phi: float
    second_theta: float
    second_phi: float
    people: int
    first: float | None
    second: float | None
    p: float | None
    p_holm: float | None
    people_advantage: float | None
    ours: float | None
    low: float | None
    high: float | None
    same_sign: bool | None
    settled: bool

    @property
    def preferred(self) -> str:
        """Whether we prefer the view that people prefer."""
        if self.same_sign is None:
            return "–"
        word = "yes" if self.same_sign else "no"
        return word if self.settled else f"leans {word}"


class Agreement(Table):
    """Of one measure: how many settled tasks agree, how likely by chance, and how many only lean."""

    source: str
    measure: str
    tasks: int
    agree: int
    chance: float | None
    leaning: int


class Own(Table):
    """How much there is of own trials.

    Attributes:
        source: what they are called. synthetic: whether they are the scripted operator's.
        people, attempts, counted: participants, ended attempts, and how many of them count.
        left_out: how many did not, by reason.
        least_people: from how many on more than counts is told.
    """

    source: str
    synthetic: bool
    people: int
    attempts: int
    counted: int
    left_out: dict[str, int]
    least_people: int


class Change(Table):
    """See :class:`pipeline.stats.practice.Change`."""

    people: int
    change: float | None
    low: float | None
    high: float | None
    p: float | None


class PeopleLearning(Table):
    """Of a scene and measure: from trial to trial within a block, and from the first block to the second."""

    scene: str
    measure: str
    per_trial: Change
    per_block: Change


class Course(Table):
    """Of a trial of the session, the people's geometric mean relative to their own under the same view."""

    trial: int
    people: int
    time: float
    distance: float


class Implied(Table):
    """See :class:`pipeline.stats.published.Implied`."""

    source: str
    scene: str
    measure: str
    unit: str
    t: float
    df: int
    sd: float
    effect: float
    people: int | None


class People(Table):
    """``reports/people.json``."""

    own: Own | None
    alpha: float
    power: float
    rows: list[Compared]
    agreements: list[Agreement]
    tests: list[Tested]
    learning: list[PeopleLearning]
    course: list[Course]
    published: list[Implied]


@dataclass(frozen=True, eq=False)
class PeopleResults:
    """What is known of people: aggregates, each one's means, and the course of trials."""

    found: People
    means: pl.DataFrame
    course: pl.DataFrame


def read_people(path: Path, points: Path) -> PeopleResults:
    """Reads what stage `people` wrote.

    Raises:
        BelvedereError: a file is missing or foreign.
    """
    found = read_model(People, path, "people")
    means = read_points(points / "means.parquet", MEANS)
    return PeopleResults(found, means, read_points(points / "course.parquet", COURSE))
