"""The page's section on people: the published table and own trials in one layout, tests, plots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from pipeline.reporting import numbers
from pipeline.reporting.people_plots import box_plot, course_plot
from pipeline.reporting.people_tables import Compared, People, PeopleResults
from pipeline.reporting.people_tests import Tested

Angles = tuple[float, float]
_NAMES = {"time": "Task time", "distance error": "Distance error"}


@dataclass(frozen=True)
class Columns:
    """A task's two views, which are two columns of the table."""

    scene: str
    first: Angles
    second: Angles


@dataclass(frozen=True)
class Source:
    """Who measured, with the lines of the table: a label and cells, one a view or one a task."""

    name: str
    people: str
    means: list[tuple[str, list[str]]]
    p_values: list[tuple[str, list[str]]]


@dataclass(frozen=True)
class TestRow:
    """A test of two views as it is written."""

    scene: str
    measure: str
    views: str
    test: str
    people: str
    difference: str
    interval: str
    statistic: str
    p: str
    p_holm: str
    effect: str
    effect_interval: str


@dataclass(frozen=True)
class PeoplePage:
    """All that the template places.

    Attributes:
        found: the aggregates.
        columns, sources: the table in the paper's layout.
        tests: of own trials.
        boxes: a plot a task. course: plots of the session.
    """

    found: People
    columns: list[Columns]
    sources: list[Source]
    tests: list[TestRow]
    boxes: list[Markup]
    course: list[Markup]


def people_page(results: PeopleResults) -> PeoplePage:
    """Prepares the section."""
    found = results.found
    columns = list(dict.fromkeys(_columns(row) for row in found.rows))
    names = dict.fromkeys(row.source for row in found.rows)
    boxes = [Markup(box_plot(results, scene)) for scene in dict.fromkeys(results.means["scene"].to_list())]
    course = [] if not found.course else [Markup(course_plot(results, what)) for what in ("time", "distance")]
    return PeoplePage(
        found=found,
        columns=columns,
        sources=[_source(name, [r for r in found.rows if r.source == name], columns) for name in names],
        tests=[line for row in found.tests for line in _tests(row)],
        boxes=boxes,
        course=course,
    )


def _columns(row: Compared | Tested) -> Columns:
    return Columns(row.scene, (row.first_theta, row.first_phi), (row.second_theta, row.second_phi))


def _source(name: str, rows: Sequence[Compared], columns: Sequence[Columns]) -> Source:
    means, p_values = [], []
    for measure in dict.fromkeys(row.measure for row in rows):
        own = {_columns(row): row for row in rows if row.measure == measure}
        label = _NAMES.get(measure, measure)
        unit = next(iter(own.values())).unit
        found = [own.get(column) for column in columns]
        cells = [numbers.fixed(v, 2) for r in found for v in ((r.first, r.second) if r else (None, None))]
        means.append((f"{label} ({unit})", cells))
        p_values.append((f"p of {label.lower()}", [numbers.p_value(r.p if r else None) for r in found]))
    counts = sorted({row.people for row in rows})
    people = f"{counts[0]}" if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
    return Source(name, people, means, p_values)


def _tests(row: Tested) -> Iterator[TestRow]:
    """Three lines: the paper's test, and two within people."""
    both = f"{row.people_first} and {row.people_second}"
    for name, t, p_holm, people in (
        ("two-sample t", row.two_sample, row.two_sample_holm, both),
        ("paired t", row.paired, row.paired_holm, str(row.pairs)),
    ):
        if t is None:
            yield _nothing(row, name, people)
            continue
        yield TestRow(
            *_named(row), name, people, numbers.fixed(t.difference, 2), numbers.interval(t.low, t.high),
            f"t({t.df:.0f}) = {numbers.fixed(t.t, 2)}", numbers.p_value(t.p), numbers.p_value(p_holm),
            f"{'g' if name == 'two-sample t' else 'd'} = {numbers.fixed(t.effect, 2)}",
            numbers.interval(t.effect_low, t.effect_high),
        )  # fmt: skip
    ranks = row.signed_ranks
    if ranks is None:
        yield _nothing(row, "Wilcoxon", str(row.pairs))
        return
    yield TestRow(
        *_named(row), "Wilcoxon", str(row.pairs), numbers.fixed(ranks.shift, 2),
        numbers.interval(ranks.low, ranks.high), f"W = {ranks.w:g}", numbers.p_value(ranks.p),
        numbers.p_value(row.signed_ranks_holm), f"r = {numbers.fixed(ranks.effect, 2)}", numbers.MISSING,
    )  # fmt: skip


def _named(row: Tested) -> tuple[str, str, str]:
    angles = [(row.first_theta, row.first_phi), (row.second_theta, row.second_phi)]
    first, second = (f"({numbers.degrees(t)}, {numbers.degrees(p)})" for t, p in angles)
    return row.scene, f"{row.measure}, {row.unit}", f"{first} less {second}"


def _nothing(row: Tested, test: str, people: str) -> TestRow:
    return TestRow(*_named(row), test, people, *[numbers.MISSING] * 7)
