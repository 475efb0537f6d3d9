"""A table of views × repeats with common draws: its errors and intervals.

Repeat r uses the same episodes and seeds in every view, so it is a block of a randomised complete
block design, value = mean + view + repeat + residual, with repeats and residuals random. What the
repeats share cancels in a difference between views but not in a view's own mean, so the two have
errors of their own. The model takes the residuals as normal and equally spread in all views.

Sources: D. C. Montgomery, Design and Analysis of Experiments, section 4.1 (the mean squares);
F. E. Satterthwaite, Biometrics Bulletin 2 (1946) 110-114 (df of a sum of mean squares);
J. W. Tukey's studentized range, as in R. G. Miller, Simultaneous Statistical Inference (1981), ch. 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import stats

_NODES = (30.0, 60.0, float("inf"))  # degrees of freedom


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
            repeat or one view.
    """

    means: np.ndarray
    repeats: int
    within: Error | None
    residual: Error | None

    def errors(self) -> dict[str, float | None]:
        """Both errors by name: of a view's own mean (``pooled``), of differences (``residual``)."""
        within, residual = self.within, self.residual
        return {
            "pooled_sd": within.sd if within else None,
            "df": within.df if within else None,
            "residual_sd": residual.sd if residual else None,
            "residual_df": residual.df if residual else None,
        }


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
    ms_residual = float(np.sum((values - means[:, None] - shifts) ** 2)) / df_residual
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


def difference_half_width(fit: TwoWay, confidence: float) -> float | None:
    """Half the width of Tukey's interval for a difference of two view means: q · s_residual / √R.

    The intervals hold for all pairs at once, hence also for the comparisons with a best view that
    the same data chose. With two views this is the paired t interval. ``None`` without an error.
    """
    if fit.residual is None:
        return None
    quantile = studentized_range(confidence, len(fit.means), fit.residual.df)
    return quantile * fit.residual.sd / fit.repeats**0.5


def studentized_range(confidence: float, means: int, df: float) -> float:
    """Tukey's quantile q for so many means.

    Above 30 degrees of freedom it is read off a parabola in 1/df through 30, 60 and infinity, which is
    right to one part in 100,000 (a test); SciPy integrates anew for each.
    """
    if df <= _NODES[0]:
        return _studentized_range(confidence, means, df)
    values = [_studentized_range(confidence, means, node) for node in _NODES]
    return float(np.polyval(np.polyfit([1 / node for node in _NODES], values, 2), 1 / df))


@lru_cache(maxsize=1024)
def _studentized_range(confidence: float, means: int, df: float) -> float:
    return float(stats.studentized_range.ppf(confidence, means, df))
