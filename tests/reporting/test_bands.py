"""Bands of learning curves against SciPy's own t interval."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest
from scipy import stats

from pipeline.reporting.bands import POINTS, band, frames_to


def _curve(values: list[list[float]]) -> pl.DataFrame:
    """One list of means per repeat; 100 frames a generation."""
    return pl.DataFrame(
        [
            {"repeat": r, "generation": g, "frames": 100 * (g + 1), "mean": mean, "best": mean}
            for r, means in enumerate(values)
            for g, mean in enumerate(means)
        ]
    )


@pytest.mark.parametrize("confidence", [0.95, 0.8])
def test_band_is_the_t_interval_of_each_generation(confidence: float) -> None:
    values = np.random.default_rng(1).normal(-5, 1, (4, 6))
    table = band(_curve(values.tolist()), confidence)
    expected = stats.ttest_1samp(values, 0).confidence_interval(confidence)
    np.testing.assert_allclose(table["mean"], values.mean(axis=0))
    np.testing.assert_allclose(table["low"], expected.low)
    np.testing.assert_allclose(table["high"], expected.high)
    assert table["frames"].to_list() == [100, 200, 300, 400, 500, 600]


def test_rows_may_come_in_any_order() -> None:
    curve = _curve([[-3.0, -2.0, -1.0], [-4.0, -2.5, -1.5]])
    assert band(curve.sample(fraction=1, shuffle=True, seed=2), 0.95).equals(band(curve, 0.95))


def test_generations_that_a_repeat_has_not_reached_are_left_out() -> None:
    assert band(_curve([[-3.0, -2.0, -1.0], [-4.0, -2.5]]), 0.95)["mean"].to_list() == [-3.5, -2.25]


def test_one_repeat_has_no_band() -> None:
    table = band(_curve([[-3.0, -2.0]]), 0.95)
    assert table["mean"].to_list() == [-3.0, -2.0]
    assert table["low"].null_count() == table["high"].null_count() == 2


def test_long_curves_are_thinned_and_keep_both_ends() -> None:
    means = np.linspace(-9, -1, 1001).tolist()
    table = band(_curve([means, means]), 0.95)
    assert table.height <= POINTS + 1
    assert (table["mean"][0], table["mean"][-1]) == pytest.approx((-9, -1))
    assert table["frames"].is_sorted()


def test_a_level_is_reached_once_and_for_all_that_comes_after() -> None:
    table = band(_curve([[-3.0, -2.0, -2.5, -1.0]]), 0.95)
    assert [frames_to(table, level) for level in (-4.0, -2.0, -1.5, 0.0)] == [100, 200, 400, None]
