"""Pairs of views: effect sizes, power and repeats needed, against SciPy and simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.blocks import difference_half_width, two_way
from pipeline.stats.branches import Results
from pipeline.stats.pairs import gap_worth_caring, hedges_g, pairs, power, repeats_needed
from pipeline.stats.params import RankingParams


def test_two_views_against_scipy() -> None:
    values = np.random.default_rng(1).normal(size=(2, 6)) + np.array([[0.5], [0.0]])
    (pair,) = pairs(["a", "b"], values, two_way(values), 0.95)
    assert (pair.first, pair.second) == ("a", "b")
    interval = stats.ttest_rel(values[0], values[1]).confidence_interval(0.95)
    assert (pair.low, pair.high) == (
        pytest.approx(interval.low, rel=1e-6),
        pytest.approx(interval.high, rel=1e-6),
    )
    assert pair.welch_p == pytest.approx(stats.ttest_ind(values[0], values[1], equal_var=False).pvalue)


def test_g_is_unbiased_in_small_samples() -> None:
    rng, df = np.random.default_rng(2), 4
    estimates = [
        hedges_g(float(a.mean() - b.mean()), float(np.sqrt((a.var(ddof=1) + b.var(ddof=1)) / 2)), df)
        for a, b in rng.normal(size=(20_000, 2, 3)) + np.array([[0.8], [0.0]])
    ]
    error = np.std(estimates) / len(estimates) ** 0.5
    assert abs(np.mean(estimates) - 0.8) < 4 * error
    assert np.mean(estimates) / (1 - 3 / (4 * df - 1)) > 0.9  # without the correction it would be 1.0


@pytest.mark.parametrize(("views", "repeats", "gap"), [(2, 5, 2.0), (4, 6, 1.5)])
def test_power_is_what_simulated_tables_show(views: int, repeats: int, gap: float) -> None:
    rng, tables = np.random.default_rng(3), 1500
    values = rng.normal(size=(tables, views, repeats))
    values[:, 0] += gap
    fits = [two_way(table) for table in values]
    separated = sum(abs(fit.means[0] - fit.means[1]) > difference_half_width(fit, 0.95) for fit in fits)
    expected = power(gap, 1.0, views, repeats, 0.95)
    assert stats.binomtest(separated, tables, expected).pvalue > 0.001


def test_repeats_needed_are_the_fewest_with_enough_power() -> None:
    needed = repeats_needed(1.0, 1.0, 3, 0.95)
    assert needed is not None
    assert power(1.0, 1.0, 3, needed, 0.95) >= 0.8 > power(1.0, 1.0, 3, needed - 1, 0.95)
    assert repeats_needed(0.0, 1.0, 3, 0.95) is None
    assert repeats_needed(1e-4, 1.0, 3, 0.95) is None


def test_one_repeat_or_view_has_no_pairs() -> None:
    for shape in ((3, 1), (1, 3)):
        values = np.zeros(shape)
        assert pairs(["a", "b", "c"], values, two_way(values), 0.95) == []


def test_the_gap_worth_caring_about_is_a_share_of_the_way_from_blind_to_the_expert() -> None:
    rng, repeats = np.random.default_rng(4), 4
    returns = rng.normal(size=(3, repeats))
    anchors = {"blind": np.array([-9.0, -10.0, -10.0, -11.0]), "expert": np.array([-1.0, -2.0, -2.0, -3.0])}
    results = Results({}, {}, returns, anchors, {})
    params = RankingParams(confidence=0.95, equivalence_margin=0.25)
    fit = two_way(returns)
    gap = gap_worth_caring(results, fit, params)
    assert (gap.score, gap.metres) == (0.25, pytest.approx(2.0))
    assert gap.repeats_needed == repeats_needed(2.0, fit.residual.sd, 3, 0.95)
    assert gap_worth_caring(results, two_way(returns[:, :1]), params).repeats_needed is None
