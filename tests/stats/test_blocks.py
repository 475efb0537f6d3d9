"""Intervals of a table of views × repeats, held to SciPy and to simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.blocks import difference_half_width, mean_half_width, studentized_range, two_way

CONFIDENCE = 0.95


def table(views: int, repeats: int, seed: int = 0, shared: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return shared * rng.normal(size=repeats) + rng.normal(size=(views, repeats)) + np.arange(views)[:, None]


def test_one_view_has_the_one_sample_t_interval() -> None:
    values = table(1, 5)
    ours = mean_half_width(two_way(values), CONFIDENCE)
    theirs = stats.ttest_1samp(values[0], 0).confidence_interval(CONFIDENCE)
    assert ours == pytest.approx((theirs.high - theirs.low) / 2)


@pytest.mark.parametrize("repeats", [2, 3, 10])
def test_two_views_have_the_paired_t_interval(repeats: int) -> None:
    values = table(2, repeats)
    ours = difference_half_width(two_way(values), CONFIDENCE)
    theirs = stats.ttest_rel(values[0], values[1]).confidence_interval(CONFIDENCE)
    assert ours == pytest.approx((theirs.high - theirs.low) / 2)


def test_without_a_shared_shift_differences_are_tukeys_of_the_one_way_model() -> None:
    """With the repeats' shifts taken out, the residual mean square is the one-way one but for its df."""
    values = table(4, 5)
    values = values - values.mean(axis=0) + values.mean()
    ours = difference_half_width(two_way(values), CONFIDENCE)
    interval = stats.tukey_hsd(*values).confidence_interval(CONFIDENCE)
    theirs = (interval.high[0, 1] - interval.low[0, 1]) / 2
    one_way, blocked = 4 * (5 - 1), (4 - 1) * (5 - 1)
    quantile = stats.studentized_range.ppf(CONFIDENCE, 4, [one_way, blocked])
    assert ours == pytest.approx(theirs * quantile[1] / quantile[0] * (one_way / blocked) ** 0.5)


def test_the_pooled_variance_is_the_mean_of_the_views_variances() -> None:
    values = table(5, 4)
    within = two_way(values).within
    assert within is not None
    assert within.sd**2 == pytest.approx(values.var(axis=1, ddof=1).mean())
    assert 4 - 1 <= within.df <= 5 * (4 - 1)


def test_degrees_of_freedom_count_alike_views_once() -> None:
    row = table(1, 6)
    alike = two_way(np.vstack([row, row + 3, row - 1])).within
    assert alike is not None and alike.df == pytest.approx(6 - 1)


def test_a_repeats_shift_leaves_differences_alone() -> None:
    values = table(3, 4)
    shifted = values + np.array([0.0, 7.0, 0.0, 0.0])
    assert difference_half_width(two_way(shifted), CONFIDENCE) == pytest.approx(
        difference_half_width(two_way(values), CONFIDENCE)
    )
    assert np.diff(two_way(shifted).means) == pytest.approx(np.diff(two_way(values).means))


def test_intervals_are_equivariant() -> None:
    """Neither the order of views or repeats nor the unit of the returns matters."""
    values = table(4, 5)
    fit, other = two_way(values), two_way(-3 * values[::-1, [2, 0, 4, 1, 3]])
    assert other.means == pytest.approx(-3 * fit.means[::-1])
    for half_width in (mean_half_width, difference_half_width):
        assert half_width(other, CONFIDENCE) == pytest.approx(3 * half_width(fit, CONFIDENCE))


def test_without_an_error_there_is_no_interval() -> None:
    single_repeat, single_view = two_way(table(3, 1)), two_way(table(1, 3))
    assert mean_half_width(single_repeat, CONFIDENCE) is None
    assert difference_half_width(single_repeat, CONFIDENCE) is None
    assert difference_half_width(single_view, CONFIDENCE) is None
    assert set(single_repeat.errors().values()) == {None}


def test_no_spread_gives_intervals_of_no_width() -> None:
    fit = two_way(np.ones((3, 4)))
    assert mean_half_width(fit, CONFIDENCE) == 0
    assert difference_half_width(fit, CONFIDENCE) == 0


@pytest.mark.parametrize("shared", [0.0, 1.0, 3.0])
def test_coverage_on_normal_tables_is_nominal(shared: float) -> None:
    """2,000 tables of 4 views × 3 repeats: the binomial error of a coverage of 95 % is 0.5 %.

    Tukey's intervals are exact; Satterthwaite's degrees of freedom are an approximation.
    """
    rng, tables, views, repeats = np.random.default_rng(1), 2000, 4, 3
    mean_holds = all_pairs_hold = 0
    for _ in range(tables):
        fit = two_way(shared * rng.normal(size=repeats) + rng.normal(size=(views, repeats)))
        mean_holds += abs(fit.means[0]) <= (mean_half_width(fit, CONFIDENCE) or 0)
        all_pairs_hold += np.ptp(fit.means) <= (difference_half_width(fit, CONFIDENCE) or 0)
    assert 0.92 <= mean_holds / tables <= 0.97
    assert 0.935 <= all_pairs_hold / tables <= 0.965


@pytest.mark.parametrize("df", [4.0, 30.5, 85.0, 300.0, 1e6])
def test_the_studentized_range_against_scipy(df: float) -> None:
    expected = stats.studentized_range.ppf(CONFIDENCE, 5, df)
    assert studentized_range(CONFIDENCE, 5, df) == pytest.approx(expected, rel=1e-5)
