"""A table of views × repeats with common draws: its errors and intervals.

Repeat r uses the same episodes and seeds in every view, so it is a block of a randomised complete
block design, value = mean + view + repeat + residual, with repeats and residuals random. What the
repeats share cancels in a difference between views but not in a view's own mean, so the two have
errors of their own. The model takes the residuals as normal and equally spread in all views.

Sources: D. C. Montgomery, Design and Analysis of Experiments, section 4.1 (the mean squares);
F. E. Satterthwaite, Biometrics Bulletin 2 (1946) 110-114 (df of a sum of mean squares).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

_ROUNDING = 8 * np.finfo(float).eps


@dataclass(frozen=True)
class Error:
    """The spread of one repeat: standard deviation, in the table's unit, and degrees of freedom."""

    sd: float
    df: float


@dataclass(frozen=True)
class TwoWay:
    """A table taken apart.

    Attributes:
        means: (view,) mean of each view.
        repeats: number of repeats.
        within: a repeat's spread within its view, pooled over the views; ``None`` with one repeat.
        residual: what is left of it once the repeat's own shift is taken out; ``None`` with one
            repeat or one view, exactly 0 where views differ by the same in every repeat.
    """

    means: np.ndarray
    repeats: int
    within: Error | None
    residual: Error | None


def two_way(values: np.ndarray) -> TwoWay:
    """Fits the additive two-way model.

    The residual mean square has (V - 1)(R - 1) degrees of freedom. The variance within views,
    pooled, is (MS_repeat + (V - 1) MS_residual) / V. It would have V (R - 1) degrees of freedom, were
    views independent; common draws make them alike, so Satterthwaite's are used, which lie between
    R - 1 (views all alike) and V (R - 1).

    Args:
        values: (view, repeat), at least one of each, finite.
    """
    views, repeats = values.shape
    means = values.mean(axis=1)
    if repeats == 1:
        return TwoWay(means, repeats, None, None)
    shifts = values.mean(axis=0) - values.mean()
    df_repeat, df_residual = repeats - 1, (views - 1) * (repeats - 1)
    ms_repeat = views * float(np.sum(shifts**2)) / df_repeat
    if views == 1:
        return TwoWay(means, repeats, Error(ms_repeat**0.5, df_repeat), None)
    residuals = values - means[:, None] - shifts
    residuals[np.abs(residuals) < _ROUNDING * np.abs(values).max()] = 0.0  # nothing may be divided by it
    ms_residual = float(np.sum(residuals**2)) / df_residual
    parts = np.array([ms_repeat / views, (views - 1) * ms_residual / views])
    variance = float(parts.sum())
    spread = float(np.sum((parts / (variance or 1.0)) ** 2 / [df_repeat, df_residual]))
    df_within = 1 / spread if spread else float(views * df_repeat)
    return TwoWay(means, repeats, Error(variance**0.5, df_within), Error(ms_residual**0.5, df_residual))


def mean_half_width(fit: TwoWay, confidence: float) -> float | None:
    """Half the width of a view mean's t interval: t · s_within / √R; ``None`` with one repeat.

    Each interval holds for its own view; they are not simultaneous.
    """
    if fit.within is None:
        return None
    quantile = float(stats.t.ppf((1 + confidence) / 2, fit.within.df))
    return quantile * fit.within.sd / fit.repeats**0.5


def own_interval(values: np.ndarray, confidence: float) -> tuple[float, float | None, float | None]:
    """A view's mean with the t interval of its repeats (repeat,) alone; no bounds with one repeat."""
    fit = two_way(values[None, :])
    mean, half = float(fit.means[0]), mean_half_width(fit, confidence)
    return (mean, None, None) if half is None else (mean, mean - half, mean + half)
