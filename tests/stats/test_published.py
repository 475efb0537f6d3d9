"""The paper's Table 2 as far as its summary figures allow: what spread its p-values imply, and no more."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.published import Implied, implied
from pipeline.study.subjects import read_subjects
from tests.support import ROOT

TABLE = read_subjects(ROOT / "data/reference/subjects.csv")
each_row = pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row.scene}-{row.measure}")


def of(row) -> Implied:
    return implied(row.first, row.second, row.p, row.people, 0.05, 0.8)


@each_row
def test_scipys_t_test_of_the_implied_figures_gives_the_published_p(row) -> None:
    found = of(row)
    again = stats.ttest_ind_from_stats(row.first, found.sd, row.people, row.second, found.sd, row.people)
    assert (again.pvalue, again.statistic) == pytest.approx((row.p, found.t))


@each_row
def test_made_up_people_with_the_implied_figures_have_the_published_p(row) -> None:
    found, rng = of(row), np.random.default_rng(1)
    drawn = stats.zscore(rng.normal(size=(2, row.people)), axis=1, ddof=1) * found.sd
    assert stats.ttest_ind(drawn[0] + row.first, drawn[1] + row.second).pvalue == pytest.approx(row.p)


@each_row
def test_the_published_figures_do_not_contradict_one_another(row) -> None:
    """Times and distances are above zero. The standard deviation of n such values with mean m is at most m √n
    (all but one at zero), so the pooled one at most the root of the mean of both squares."""
    most = np.sqrt(row.people * (row.first**2 + row.second**2) / 2)
    assert 0 < of(row).sd < most


def test_what_is_significant_is_what_the_paper_says_and_holm_leaves_two() -> None:
    """Section IV-D: all but the time of the task on one axis, at 5 %."""
    assert [row.p < 0.05 for row in TABLE] == [False, True, True, True, True, True]
    ordered = sorted(row.p for row in TABLE)
    assert [p * (6 - n) < 0.05 for n, p in enumerate(ordered)] == [True, True, False, False, False, False]


def test_effects_and_people_needed() -> None:
    effects = {(row.scene, row.measure): of(row) for row in TABLE}
    assert all(found.effect < 0 for found in effects.values())  # the first view is the better one throughout
    time = effects["panda_1dof", "time"]
    assert time.effect == pytest.approx(time.t * np.sqrt(2 / 11))
    assert [found.people for found in effects.values()] == [40, 18, 20, 6, 15, 7]
