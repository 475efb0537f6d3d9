"""Factorial effects: against least squares, scipy, and simulated tables."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.factorial import DIFFERS, NO_DIFFERENCE, NOT_SETTLED, factorial, find_grid, word

THETAS, PHIS = [0.0, 45.0, 90.0], [30.0, 45.0]
ANGLES = [(t, p) for p in PHIS for t in THETAS]


def grid_of(angles: list[tuple[float, float]]):
    return find_grid([t for t, _ in angles], [p for _, p in angles])


def table(seed: int, repeats: int = 4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(6, repeats)) + rng.normal(size=repeats) * 2


def test_a_grid_is_found_whatever_stands_beside_it() -> None:
    grid = grid_of([(20.0, 37.0), *ANGLES])
    assert grid is not None
    assert grid.levels == {"theta": THETAS, "phi": PHIS}
    np.testing.assert_array_equal(grid.views, [[1, 4], [2, 5], [3, 6]])
    pair = grid_of([(90.0, 45.0), (90.0, 30.0)])
    assert pair is not None and pair.levels == {"theta": [90.0], "phi": [30.0, 45.0]}
    assert grid_of([(0.0, 30.0), (45.0, 45.0)]) is None
    assert grid_of([(0.0, 30.0)]) is None


def test_f_tests_are_those_of_least_squares() -> None:
    """Each factor's F from the residual sums of squares of linear models with and without it."""
    values, grid = table(1), grid_of(ANGLES)
    assert grid is not None
    found = factorial(values, grid, 0.95, 0.1)
    assert found is not None
    view, repeat = (index.ravel() for index in np.indices(values.shape))
    theta, phi = (
        np.array([THETAS.index(t) for t, _ in ANGLES])[view],
        np.array([PHIS.index(p) for _, p in ANGLES])[view],
    )

    def dummies(index: np.ndarray) -> np.ndarray:
        return (index[:, None] == np.arange(1, index.max() + 1)).astype(float)

    def left_over(*parts: np.ndarray) -> float:
        design = np.concatenate([np.ones((values.size, 1)), *parts], axis=1)
        solution = np.linalg.lstsq(design, values.ravel(), rcond=None)[0]
        return float(((values.ravel() - design @ solution) ** 2).sum())

    blocks, both = dummies(repeat), dummies(view)
    t, p = dummies(theta), dummies(phi)
    error_df = 5 * 3
    error = left_over(blocks, both) / error_df
    expected = {
        "theta": (left_over(blocks, p) - left_over(blocks, t, p)) / 2 / error,
        "phi": (left_over(blocks, t) - left_over(blocks, t, p)) / error,
        "interaction": (left_over(blocks, t, p) - left_over(blocks, both)) / 2 / error,
    }
    assert found.df_error == error_df
    for name, f in expected.items():
        assert found.tests[name].f == pytest.approx(f)
        assert found.tests[name].p == pytest.approx(stats.f.sf(f, found.tests[name].df, error_df))


def test_two_views_are_a_paired_t_test() -> None:
    values, grid = table(2)[:2], grid_of([(90.0, 30.0), (90.0, 45.0)])
    assert grid is not None
    found = factorial(values, grid, 0.95, 0.1)
    assert found is not None
    (effect,) = found.effects
    paired = stats.ttest_rel(values[0], values[1])
    interval = paired.confidence_interval(0.95)
    assert found.tests["phi"].p == pytest.approx(paired.pvalue)
    assert (effect.low, effect.high) == (
        pytest.approx(interval.low, rel=1e-6),
        pytest.approx(interval.high, rel=1e-6),
    )
    narrow = paired.confidence_interval(0.90)
    assert effect.equivalence_low == pytest.approx(narrow.low)
    assert effect.equivalence_high == pytest.approx(narrow.high)


def test_intervals_hold_at_once_for_all_levels_of_a_factor() -> None:
    grid = grid_of(ANGLES)
    assert grid is not None
    missed, tables = 0, 600
    for seed in range(tables):
        found = factorial(table(seed, 3), grid, 0.95, 0.1)
        assert found is not None
        missed += any(e.factor == "theta" and not e.low <= 0 <= e.high for e in found.effects)
    assert stats.binomtest(missed, tables, 0.05).pvalue > 0.001


def test_one_repeat_tells_nothing() -> None:
    grid = grid_of(ANGLES)
    assert grid is not None
    assert factorial(table(3, 1), grid, 0.95, 0.1) is None


def test_words() -> None:
    assert word(0.3, 0.2, 0.15, 0.1) == DIFFERS
    assert word(0.02, 0.05, 0.04, 0.1) == NO_DIFFERENCE
    assert word(0.08, 0.1, 0.09, 0.1) == NOT_SETTLED
    assert word(0.05, 0.04, 0.03, 0.1) == DIFFERS  # small, yet there
