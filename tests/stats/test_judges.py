"""Judges held against each other: against scipy, and on simulated tables."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.factorial import factorial, find_grid
from pipeline.stats.judges import effects_by_judge, holm, judge_by_view

ANGLES = [(t, p) for p in (30.0, 45.0) for t in (0.0, 45.0, 90.0)]


def judged(rng: np.random.Generator, repeats: int, spread: float) -> np.ndarray:
    return rng.normal(size=(6, repeats)) * spread + rng.normal(size=repeats)


def test_of_two_views_it_is_welchs_test_of_the_paired_differences() -> None:
    rng = np.random.default_rng(1)
    first, second = rng.normal(size=(2, 5)), rng.normal(size=(2, 4)) * 3
    found = judge_by_view(first, second)
    welch = stats.ttest_ind(first[0] - first[1], second[0] - second[1], equal_var=False)
    assert found is not None
    assert found.f == pytest.approx(welch.statistic**2)
    assert found.df_error == pytest.approx(welch.df)
    assert found.p == pytest.approx(welch.pvalue)
    grid = find_grid([90.0, 90.0], [30.0, 45.0])
    assert grid is not None
    each = [factorial(values, grid, 0.95, 0.1) for values in (first, second)]
    assert each[0] and each[1]
    (effect,) = effects_by_judge(each[0], each[1], 0.95)
    interval = welch.confidence_interval(0.95)
    assert effect.p == pytest.approx(welch.pvalue)
    assert (effect.low, effect.high) == (pytest.approx(interval.low), pytest.approx(interval.high))


@pytest.mark.parametrize(("repeats", "spread"), [((3, 3), 1.0), ((4, 3), 3.0)])
def test_judges_that_agree_are_seldom_told_apart(repeats: tuple[int, int], spread: float) -> None:
    rng, tables = np.random.default_rng(2), 1000
    tests = [
        judge_by_view(judged(rng, repeats[0], 1.0), judged(rng, repeats[1], spread)) for _ in range(tables)
    ]
    wrong = sum(test is not None and test.p < 0.05 for test in tests)
    assert stats.binomtest(wrong, tables, 0.05).pvalue > 0.001


def test_a_judge_that_sees_a_difference_and_one_that_does_not_are_told_apart() -> None:
    rng = np.random.default_rng(3)
    first, second = judged(rng, 4, 0.1), judged(rng, 4, 0.1)
    first[:3] += 1.0  # the views at φ = 30°
    found = judge_by_view(first, second)
    assert found is not None and found.p < 0.001
    grid = find_grid([t for t, _ in ANGLES], [p for _, p in ANGLES])
    assert grid is not None
    each = [factorial(values, grid, 0.95, 0.1) for values in (first, second)]
    assert each[0] and each[1]
    effects = {(e.factor, e.first_deg, e.second_deg): e for e in effects_by_judge(each[0], each[1], 0.95)}
    assert effects["phi", 30.0, 45.0].low > 0.5
    assert all(e.p > 0.01 for e in effects.values() if e.factor == "theta")


def test_one_repeat_tells_nothing() -> None:
    assert judge_by_view(np.zeros((3, 1)), np.zeros((3, 4))) is None


def test_holm_as_worked_out_by_hand() -> None:
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.5, 0.9]) == pytest.approx([1.0, 1.0])
    assert holm([]) == []
