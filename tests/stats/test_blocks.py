"""Intervals of a table of views × repeats, held to SciPy and to simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.blocks import mean_half_width, own_interval, two_way

CONFIDENCE = 0.95


def table(views: int, repeats: int, seed: int = 0, shared: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return shared * rng.normal(size=repeats) + rng.normal(size=(views, repeats)) + np.arange(views)[:, None]


def test_one_view_has_the_one_sample_t_interval() -> None:
    values = table(1, 5)
    ours = mean_half_width(two_way(values), CONFIDENCE)
    theirs = stats.ttest_1samp(values[0], 0).confidence_interval(CONFIDENCE)
    assert ours == pytest.approx((theirs.high - theirs.low) / 2)


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


def test_intervals_are_equivariant() -> None:
    """Neither the order of views or repeats nor the unit of the returns matters."""
    values = table(4, 5)
    fit, other = two_way(values), two_way(-3 * values[::-1, [2, 0, 4, 1, 3]])
    assert other.means == pytest.approx(-3 * fit.means[::-1])
    assert mean_half_width(other, CONFIDENCE) == pytest.approx(3 * mean_half_width(fit, CONFIDENCE))


def test_a_views_own_interval_is_the_one_sample_t_interval() -> None:
    (values,) = table(1, 4)
    expected = stats.ttest_1samp(values, 0).confidence_interval(CONFIDENCE)
    assert own_interval(values, CONFIDENCE) == pytest.approx((values.mean(), expected.low, expected.high))
    assert own_interval(values[:1], CONFIDENCE) == (values[0], None, None)


def test_without_an_error_there_is_no_interval() -> None:
    assert mean_half_width(two_way(table(3, 1)), CONFIDENCE) is None
    assert two_way(table(1, 3)).residual is None


def test_no_spread_gives_intervals_of_no_width() -> None:
    assert mean_half_width(two_way(np.ones((3, 4))), CONFIDENCE) == 0


@pytest.mark.parametrize("shared", [0.0, 1.0, 3.0])
def test_coverage_on_normal_tables_is_nominal(shared: float) -> None:
    """2,000 tables of 4 views × 3 repeats: the binomial error of a coverage of 95 % is 0.5 %.

    Satterthwaite's degrees of freedom are an approximation.
    """
    rng, tables, views, repeats = np.random.default_rng(1), 2000, 4, 3
    holds = 0
    for _ in range(tables):
        fit = two_way(shared * rng.normal(size=repeats) + rng.normal(size=(views, repeats)))
        holds += abs(fit.means[0]) <= (mean_half_width(fit, CONFIDENCE) or 0)
    assert 0.92 <= holds / tables <= 0.97
