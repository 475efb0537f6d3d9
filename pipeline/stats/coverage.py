"""How often the intervals hold what they should, on populations that are normal and on some that are not.

A table is simulated with views that are all alike, so that each difference is zero: an interval that
leaves out zero is a false positive.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import stats

from pipeline.stats.blocks import studentized_range

Population = Callable[[np.random.Generator, tuple[int, ...]], np.ndarray]


def normal(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """The model's own assumption."""
    return rng.standard_normal(shape)


def skewed(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Exponential, turned over: most trainings come near the best, some fall far short."""
    return 1.0 - rng.exponential(size=shape)


def failing(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Two kinds of training: one in five fails, six standard deviations below the others."""
    return rng.standard_normal(shape) + 1.2 - 6.0 * (rng.random(shape) < 0.2)


POPULATIONS: dict[str, Population] = {"normal": normal, "skewed": skewed, "failing": failing}


@dataclass(frozen=True)
class Coverage:
    """Shares of simulated tables.

    Attributes:
        means: in which a view's interval holds its true mean (over views and tables).
        differences: in which all intervals of differences hold zero; one less this is the rate of tables
            with a false positive.
    """

    means: float
    differences: float


def simulate(
    population: Population, views: int, repeats: int, tables: int, confidence: float, rng: np.random.Generator
) -> Coverage:
    """Simulates tables (view, repeat): the population's residuals, and normal shifts that repeats share.

    The population's mean is zero; intervals are those of :mod:`pipeline.stats.blocks`, of all tables at once.
    """
    shifts = rng.standard_normal((tables, 1, repeats))
    return covered(population(rng, (tables, views, repeats)) + shifts, confidence)


def covered(values: np.ndarray, confidence: float) -> Coverage:
    """Of tables (table, view, repeat) whose views all have mean zero."""
    _, views, repeats = values.shape
    means = values.mean(axis=2)
    shift = values.mean(axis=1) - values.mean(axis=(1, 2))[:, None]
    df_repeat, df_residual = repeats - 1, (views - 1) * (repeats - 1)
    ms_repeat = views * (shift**2).sum(axis=1) / df_repeat
    residual = values - means[..., None] - shift[:, None]
    ms_residual = (residual**2).sum(axis=(1, 2)) / df_residual
    parts = np.stack([ms_repeat, (views - 1) * ms_residual]) / views
    variance = parts.sum(axis=0)
    squares = (parts**2 / np.array([[df_repeat], [df_residual]])).sum(axis=0)
    df = np.divide(variance**2, squares, out=np.ones_like(variance), where=squares > 0)  # 0: no scatter
    half = stats.t.ppf((1 + confidence) / 2, df) * np.sqrt(variance / repeats)
    gap = np.ptp(means, axis=1)  # the widest difference decides for all
    widest = studentized_range(confidence, views, df_residual) * np.sqrt(ms_residual / repeats)
    return Coverage(float((np.abs(means) <= half[:, None]).mean()), float((gap <= widest).mean()))


def resampled(residuals: np.ndarray, tables: int, confidence: float, rng: np.random.Generator) -> Coverage:
    """A/A: tables of views that are all alike, drawn from the residuals of a real one.

    Args:
        residuals: (view, repeat), of a real table less its views' means and its repeats' shifts.
        tables: how many are drawn, each value with replacement from all residuals.
        confidence: of the intervals.
        rng: draws.
    """
    return covered(rng.choice(residuals.reshape(-1), (tables, *residuals.shape)), confidence)


def residuals(values: np.ndarray) -> np.ndarray:
    """What views and repeats leave of a table (view, repeat)."""
    return values - values.mean(axis=1, keepdims=True) - values.mean(axis=0) + values.mean()
