"""Coverage and false positives by simulation; the committed table is what the code gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from scipy import stats

from pipeline.stats.blocks import difference_half_width, mean_half_width, two_way
from pipeline.stats.coverage import POPULATIONS, covered, normal, resampled, residuals, simulate

ROOT = Path(__file__).resolve().parents[2]
TABLES = 4000


def test_all_tables_at_once_are_the_tables_one_by_one() -> None:
    values = np.random.default_rng(1).normal(size=(200, 4, 3))
    fits = [two_way(table) for table in values]
    means = [np.abs(fit.means) <= mean_half_width(fit, 0.9) for fit in fits]
    differences = [np.ptp(fit.means) <= difference_half_width(fit, 0.9) for fit in fits]
    found = covered(values, 0.9)
    assert (found.means, found.differences) == (
        pytest.approx(np.mean(means)),
        pytest.approx(np.mean(differences)),
    )


@pytest.mark.parametrize("repeats", [3, 5, 10])
@pytest.mark.parametrize("views", [2, 6])
def test_on_normal_populations_they_hold_what_they_say(views: int, repeats: int) -> None:
    found = simulate(normal, views, repeats, TABLES, 0.95, np.random.default_rng(2))
    false = round((1 - found.differences) * TABLES)
    assert stats.binomtest(false, TABLES, 0.05).pvalue > 0.001
    assert found.means == pytest.approx(0.95, abs=0.015)


def test_the_populations_have_mean_zero() -> None:
    for name, population in POPULATIONS.items():
        draws = population(np.random.default_rng(3), (400_000,))
        assert abs(draws.mean()) < 5 * draws.std() / len(draws) ** 0.5, name


def test_the_committed_table_is_what_the_code_gives() -> None:
    rows = pl.read_csv(ROOT / "data/reference/coverage.csv").to_dicts()
    assert len(rows) == 18
    for row in rows[::5]:
        rng = np.random.default_rng(4)
        found = simulate(POPULATIONS[row["population"]], row["views"], row["repeats"], TABLES, 0.95, rng)
        assert found.means == pytest.approx(row["means"], abs=0.02)
        assert found.differences == pytest.approx(row["differences"], abs=0.02)


def test_a_real_tables_residuals_give_few_false_positives() -> None:
    values = np.random.default_rng(5).normal(size=(6, 10)) + np.arange(6)[:, None]
    left = residuals(values)
    np.testing.assert_allclose(left.sum(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(left.sum(axis=1), 0, atol=1e-12)
    found = resampled(left, 5000, 0.95, np.random.default_rng(6))
    assert 1 - found.differences == pytest.approx(0.05, abs=0.014)
