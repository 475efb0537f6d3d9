"""Do viewpoints that serve the machine serve people? Signs of differences, task by task.

People's means and p-values come from a table: the published ones and a study's own. Ours come from the
rankings. The unit is the task: with three of them, three equal signs come by chance once in eight. Only tasks
in which our direction is settled are counted; others lean.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pydantic import ConfigDict, Field
from scipy import stats

from pipeline.contract.params import Section
from pipeline.stats.judges import holm

View = tuple[float, float]  # θ, φ in degrees


class Row(Section):
    """One task and measure: people's means under two views, lower is better.

    Attributes:
        source: who measured.
        scene, measure, unit: what.
        first_theta, first_phi, second_theta, second_phi: the views, degrees.
        people: how many.
        first, second: the means, in the unit; ``None`` where so few people were measured that a mean
            would tell of one of them.
        p: of the paper's two-sample t-test; ``None`` where there is none.
    """

    source: str
    scene: str
    measure: str
    unit: str
    first_theta: float
    first_phi: float
    second_theta: float
    second_phi: float
    people: int = Field(ge=0)
    first: float | None
    second: float | None
    p: float | None

    @property
    def views(self) -> tuple[View, View]:
        return (self.first_theta, self.first_phi), (self.second_theta, self.second_phi)


class Published(Row):
    """A row of the published table, in which nothing is missing."""

    people: int = Field(ge=2)
    first: float = Field(gt=0)
    second: float = Field(gt=0)
    p: float = Field(gt=0, lt=1)


class _Entry(Section):
    """A part of a ranking's JSON; what is not compared is skipped."""

    model_config = ConfigDict(extra="ignore")


class RankedView(_Entry):
    """Angles in degrees."""

    theta_deg: float
    phi_deg: float


class Pair(_Entry):
    """The first view's score less the second's, with its interval where there is one."""

    first: str
    second: str
    difference: float
    low: float | None
    high: float | None


class Ranking(_Entry):
    """What is compared of a scene's ranking."""

    viewpoints: dict[str, RankedView]
    pairs: list[Pair]


class Compared(Row):
    """People's difference beside ours.

    Attributes:
        p_holm: people's p-value after Holm's correction over all rows of the source.
        people_advantage: by how much the first view is better for people, share of the second's mean.
        ours, low, high: by how much the first view's score is higher for the world model, with its interval;
            ``None`` where a view was not ranked, or the judge cannot see there.
        same_sign: whether both prefer the same view; ``None`` where either does not say.
        settled: whether our interval lies on one side of zero.
    """

    p_holm: float | None
    people_advantage: float | None
    ours: float | None
    low: float | None
    high: float | None
    same_sign: bool | None
    settled: bool


@dataclass(frozen=True)
class Agreement:
    """Of one measure: how many tasks' signs agree, and how likely that is by chance.

    Attributes:
        source, measure: of people's rows.
        tasks: in which our direction is settled.
        agree: of them, in which people's is the same.
        chance: of as many or more, were each sign a coin's; ``None`` without a settled task.
        leaning: tasks in which our direction is not settled.
    """

    source: str
    measure: str
    tasks: int
    agree: int
    chance: float | None
    leaning: int


def compare(rows: Sequence[Row], rankings: Mapping[str, Ranking]) -> list[Compared]:
    """Each row beside the ranking of its scene, where there is one."""
    tested = {s: [r for r in rows if r.source == s and r.p is not None] for s in {r.source for r in rows}}
    adjusted = {
        id(row): p
        for own in tested.values()
        for row, p in zip(own, holm([r.p for r in own if r.p is not None]), strict=True)
    }
    return [_compared(row, adjusted.get(id(row)), rankings.get(row.scene)) for row in rows]


def agreements(compared: Sequence[Compared]) -> list[Agreement]:
    """By source and measure, in the order in which they come."""
    groups: dict[tuple[str, str], list[Compared]] = {}
    for row in compared:
        if row.same_sign is not None:
            groups.setdefault((row.source, row.measure), []).append(row)
    return [_agreement(*names, rows) for names, rows in groups.items()]


def _agreement(source: str, measure: str, rows: Sequence[Compared]) -> Agreement:
    signs = [bool(row.same_sign) for row in rows if row.settled]
    chance = float(stats.binom.sf(sum(signs) - 1, len(signs), 0.5)) if signs else None
    return Agreement(source, measure, len(signs), sum(signs), chance, len(rows) - len(signs))


def _compared(row: Row, p_holm: float | None, ranking: Ranking | None) -> Compared:
    people = None
    if row.first is not None and row.second:
        people = (row.second - row.first) / row.second
    ours, low, high = _our_difference(row, ranking) if ranking else (None, None, None)
    same = None if ours is None or not people else bool((ours > 0) == (people > 0))
    return Compared(
        **row.model_dump(),
        p_holm=p_holm,
        people_advantage=people,
        ours=ours,
        low=low,
        high=high,
        same_sign=same,
        settled=low is not None and high is not None and (low > 0 or high < 0),
    )


def _our_difference(row: Row, ranking: Ranking) -> tuple[float | None, float | None, float | None]:
    keys = {(v.theta_deg, v.phi_deg): key for key, v in ranking.viewpoints.items()}
    first, second = (keys.get(view) for view in row.views)
    for pair in ranking.pairs:
        if (pair.first, pair.second) == (first, second):
            return pair.difference, pair.low, pair.high
        if (pair.first, pair.second) == (second, first):
            return -pair.difference, _negative(pair.high), _negative(pair.low)
    return None, None, None


def _negative(bound: float | None) -> float | None:
    return None if bound is None else -bound
