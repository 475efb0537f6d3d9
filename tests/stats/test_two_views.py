"""Tests of two views against SciPy's, and what intervals have to fulfil."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.two_views import paired, shift_interval, signed_ranks, two_sample

ALPHA = 0.05


def samples(n: int, m: int, seed: int, gap: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.gamma(4.0, 2.0, n), rng.gamma(4.0, 2.0, m) + gap


@pytest.mark.parametrize(("n", "m"), [(2, 2), (11, 11), (11, 9), (40, 40)])
@pytest.mark.parametrize("gap", [-3.0, 0.0, 8.0])
def test_the_two_sample_test_is_scipys(n: int, m: int, gap: float) -> None:
    first, second = samples(n, m, n + m, gap)
    found, scipys = two_sample(first, second, ALPHA), stats.ttest_ind(first, second)
    assert found is not None
    assert (found.t, found.p, found.df) == pytest.approx((scipys.statistic, scipys.pvalue, scipys.df))
    assert (found.low, found.high) == pytest.approx(tuple(scipys.confidence_interval(1 - ALPHA)))
    assert found.difference == pytest.approx(first.mean() - second.mean())


@pytest.mark.parametrize("n", [2, 5, 11, 40])
def test_the_paired_test_is_scipys(n: int) -> None:
    first, second = samples(n, n, n)
    found, scipys = paired(first, second, ALPHA), stats.ttest_rel(first, second)
    assert found is not None
    assert (found.t, found.p, found.df) == pytest.approx((scipys.statistic, scipys.pvalue, scipys.df))
    assert (found.low, found.high) == pytest.approx(tuple(scipys.confidence_interval(1 - ALPHA)))
    assert found.effect == pytest.approx(found.t / np.sqrt(n))


@pytest.mark.parametrize("n", [2, 5, 11, 40])
def test_signed_ranks_are_scipys(n: int) -> None:
    first, second = samples(n, n, n)
    found, scipys = signed_ranks(first, second, ALPHA), stats.wilcoxon(first, second)
    assert found is not None
    assert (found.w, found.p) == pytest.approx((scipys.statistic, scipys.pvalue))
    gaps = first - second
    ranks = stats.rankdata(np.abs(gaps))
    assert found.effect == pytest.approx((ranks[gaps > 0].sum() - ranks[gaps < 0].sum()) / ranks.sum())


@pytest.mark.parametrize("n", [6, 11, 14, 25])
def test_the_interval_of_the_shift_holds_what_the_test_does_not_refuse(n: int) -> None:
    """A shift just within it is not refused at its level by SciPy's exact test, one just beyond it is."""
    first, second = samples(n, n, 3 * n)
    found = signed_ranks(first, second, ALPHA)
    assert found is not None and found.low is not None and found.high is not None
    assert found.low <= found.shift <= found.high
    for end, inwards in ((found.low, 1), (found.high, -1)):
        for step, refused in ((inwards * 1e-7, False), (-inwards * 1e-7, True)):
            p = stats.wilcoxon(first - second - (end + step), method="exact").pvalue
            assert bool(p <= ALPHA) is refused, (n, end, step, p)


def test_so_few_pairs_have_no_interval_of_that_level() -> None:
    """With five pairs the smallest exact p-value is 1 / 16."""
    first, second = samples(5, 5, 1)
    few = signed_ranks(first, second, ALPHA)
    assert few is not None and few.low is None and few.high is None
    six = signed_ranks(*samples(6, 6, 1), ALPHA)
    assert six is not None and six.low is not None


@pytest.mark.parametrize("t", [-40.0, -5.3, -0.4, 0.0, 0.9, 2.2, 12.0, 60.0])
@pytest.mark.parametrize("df", [1, 4, 10, 20, 100])
def test_the_interval_of_an_effect_inverts_the_noncentral_t(t: float, df: int) -> None:
    low, high = shift_interval(t, df, ALPHA)
    assert low < t < high
    assert stats.nct.sf(t, df, low) == pytest.approx(ALPHA / 2, abs=2e-3)
    assert stats.nct.cdf(t, df, high) == pytest.approx(ALPHA / 2, abs=2e-3)
    assert shift_interval(-t, df, ALPHA) == pytest.approx((-high, -low), abs=1e-6)


def test_the_interval_of_an_effect_holds_the_true_one_as_often_as_it_says() -> None:
    rng, true, n, held = np.random.default_rng(2), 0.8, 9, {"paired": 0, "two": 0}
    for _ in range(600):
        gaps = rng.normal(true, 1.0, n)
        one = paired(gaps, np.zeros(n), ALPHA)
        two = two_sample(rng.normal(true, 1.0, n), rng.normal(0.0, 1.0, n), ALPHA)
        assert one is not None and two is not None
        held["paired"] += one.effect_low <= true <= one.effect_high
        held["two"] += two.effect_low <= true <= two.effect_high
    assert all(0.92 < count / 600 < 0.975 for count in held.values()), held


def test_the_effect_of_two_samples_is_not_biased() -> None:
    rng, true = np.random.default_rng(4), 1.0
    found = [two_sample(rng.normal(true, 1, 6), rng.normal(0, 1, 6), ALPHA) for _ in range(3000)]
    assert np.mean([f.effect for f in found if f]) == pytest.approx(true, abs=0.04)


def test_what_tells_nothing_has_no_test() -> None:
    one, same = np.array([3.0]), np.full(6, 2.0)
    assert two_sample(one, same, ALPHA) is None and two_sample(same, same, ALPHA) is None
    assert paired(one, one, ALPHA) is None and paired(same, same + 1.0, ALPHA) is None
    values = np.random.default_rng(1).normal(10, 3, 8)
    assert paired(values, values + 0.1, ALPHA) is None  # the same gap but for rounding
    assert signed_ranks(same, same, ALPHA) is None and signed_ranks(one, one + 1, ALPHA) is None
    ties = signed_ranks(np.array([1.0, 2.0, 3.0, 4.0]), np.array([1.0, 1.0, 2.0, 3.0]), ALPHA)
    assert ties is not None and ties.effect == 1.0 and ties.shift == 1.0
