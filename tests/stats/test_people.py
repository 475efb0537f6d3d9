"""A study's own pairs of views: which are tested, Holm over the family, and what is told of few people."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.judges import holm
from pipeline.stats.people import LEAST_PEOPLE, Measured, compared_pairs, rows, view_pairs

NAMES = [f"sub-{n}" for n in range(9)]
ORDER = [("reach", (90.0, 30.0), (90.0, 45.0))]


def measured(view: str, angles: tuple[float, float], measure: str, seed: int, count: int = 9) -> Measured:
    values = np.random.default_rng(seed).gamma(5.0, 2.0, count)
    return Measured("reach", view, angles, measure, "s", dict(zip(NAMES, map(float, values), strict=False)))


def study(count: int = 9) -> list[Measured]:
    return [
        measured(view, angles, measure, seed + 10 * (measure == "time"), count)
        for seed, (view, angles) in enumerate([("a", (90.0, 45.0)), ("b", (90.0, 30.0)), ("c", (0.0, 0.0))])
        for measure in ("time", "distance")
    ]


def test_all_pairs_of_a_scene_and_the_published_ones_in_their_order() -> None:
    pairs = [(x.view, y.view, x.measure) for x, y in view_pairs(study(), ORDER)]
    assert sorted(pairs) == sorted(
        (x, y, m) for m in ("time", "distance") for x, y in (("b", "a"), ("a", "c"), ("b", "c"))
    )
    other = [Measured("other", m.view, m.angles, m.measure, m.unit, m.values) for m in study()[:2]]
    assert len(view_pairs([*study(), *other], ORDER)) == 6  # never between scenes


def test_tests_are_scipys_and_holm_is_over_the_family_of_each_kind() -> None:
    pairs = view_pairs(study(), ORDER)
    found = compared_pairs(pairs, 0.05, 0.8, synthetic=False)
    values = [[np.array([m.values[n] for n in NAMES]) for m in pair] for pair in pairs]
    for kind, scipys in (
        ("two_sample", [stats.ttest_ind(x, y).pvalue for x, y in values]),
        ("paired", [stats.ttest_rel(x, y).pvalue for x, y in values]),
        ("signed_ranks", [stats.wilcoxon(x, y).pvalue for x, y in values]),
    ):
        assert [getattr(row, kind).p for row in found] == pytest.approx(scipys)
        assert [getattr(row, f"{kind}_holm") for row in found] == pytest.approx(holm(scipys))
    assert all(row.next is not None and row.next.level == pytest.approx(0.05 / 6) for row in found)


def test_pairs_are_those_people_who_have_both() -> None:
    one, other = measured("b", (90.0, 30.0), "time", 1), measured("a", (90.0, 45.0), "time", 2, count=7)
    (found,) = compared_pairs([[one, other]], 0.05, 0.8, synthetic=False)
    assert (found.people_first, found.people_second, found.pairs) == (9, 7, 7)
    assert found.two_sample is not None and found.two_sample.df == 14
    assert found.paired is not None and found.paired.df == 6


def test_of_few_people_there_are_counts_only_and_of_the_scripted_operator_all() -> None:
    few = view_pairs(study(LEAST_PEOPLE - 1), ORDER)
    for row in compared_pairs(few, 0.05, 0.8, synthetic=False):
        told = {name for name, value in vars(row).items() if isinstance(value, float)}
        assert told == {"first_theta", "first_phi", "second_theta", "second_phi"}
        assert row.two_sample is row.paired is row.signed_ranks is row.next is None
        assert row.pairs == LEAST_PEOPLE - 1
    assert all(row.paired for row in compared_pairs(few, 0.05, 0.8, synthetic=True))
    enough = compared_pairs(view_pairs(study(LEAST_PEOPLE), ORDER), 0.05, 0.8, synthetic=False)
    assert all(row.paired for row in enough)


def test_rows_have_the_published_layout() -> None:
    pairs = view_pairs(study(), ORDER)
    found = compared_pairs(pairs, 0.05, 0.8, synthetic=False)
    told = {(r.measure, r.views): r for r in rows(found, "own trials")}
    row = told["time", ORDER[0][1:]]
    assert row.source == "own trials" and row.people == 9
    by_view = {m.view: m for m in study() if m.measure == "time"}
    assert row.first == pytest.approx(np.mean(list(by_view["b"].values.values())))
    assert row.second == pytest.approx(np.mean(list(by_view["a"].values.values())))
    assert row.p == next(
        t.two_sample.p for t in found if t.measure == "time" and t.first == "b" and t.two_sample
    )


def test_nobody_has_no_tests() -> None:
    assert compared_pairs([], 0.05, 0.8, synthetic=False) == []
