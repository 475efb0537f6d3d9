"""Dunnett's quantile against SciPy's multivariate t, its own test, and Student's t."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.contract.errors import BelvedereError
from pipeline.stats.dunnett import quantile
from pipeline.stats.tails import TAILS, tail


@pytest.mark.parametrize(
    ("comparisons", "df", "probability"),
    [
        (2, 5, 0.05),
        (2, 10, 0.05),
        (5, 10, 0.05),
        (5, 20, 0.01),
        (9, 30, 0.05),
        (2, 18, 0.008),
        (5, 50, 0.006),
    ],
)
def test_it_is_the_equicoordinate_quantile_of_a_multivariate_t(
    comparisons: int, df: int, probability: float
) -> None:
    c = quantile(comparisons, df, probability)
    shape = np.full((comparisons, comparisons), 0.5) + 0.5 * np.eye(comparisons)
    law = stats.multivariate_t(shape=shape, df=df)
    rng = np.random.default_rng(1)
    above, step = (
        1 - law.cdf(np.full(comparisons, at), maxpts=100_000, random_state=rng) for at in (c, c + 0.1)
    )
    slope = (above - step) / 0.1
    assert abs(above - probability) / slope < 0.01  # of c


def test_at_its_quantile_scipys_test_is_just_significant() -> None:
    """Two groups stand c standard errors above their control, so their p-value is the tail."""
    rng, size = np.random.default_rng(2), 5
    groups = [values - values.mean() for values in rng.normal(size=(4, size))]
    df = 4 * (size - 1)
    s = float(np.mean([values.var(ddof=1) for values in groups])) ** 0.5
    step = quantile(3, df, 0.05) * s * (2 / size) ** 0.5
    found = stats.dunnett(
        groups[1] + step, groups[2], groups[3], control=groups[0], alternative="greater", rng=rng
    )
    assert found.pvalue[0] == pytest.approx(0.05, abs=0.002)


def test_of_one_comparison_it_is_students_and_of_none_nothing() -> None:
    assert quantile(1, 7, 0.008) == pytest.approx(stats.t.isf(0.008, 7))
    assert quantile(0, 0, 0.008) == 0


def test_it_rises_with_comparisons_and_falls_with_degrees_of_freedom() -> None:
    table = np.array([[quantile(k, df, 0.008) for df in (4, 10, 40, 400)] for k in (1, 2, 5, 20)])
    assert (np.diff(table, axis=0) > 0).all() and (np.diff(table, axis=1) < 0).all()


def test_a_long_race_spends_less_at_each_look_and_a_longer_one_is_refused() -> None:
    assert [tail(0.95, most) for most in (3, 20, 21, 40)] == [0.008, 0.008, 0.006, 0.006]
    with pytest.raises(BelvedereError, match=r"41 repeats is too long.*up to 40 only"):
        tail(0.95, 41)
    with pytest.raises(BelvedereError, match=r"ranking\.confidence '0\.9' is unknown; available: 0\.95"):
        tail(0.9, 20)
    assert set(TAILS) == {0.95}
