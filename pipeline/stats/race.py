"""A race of views by repeats: one look, which tells the error, eliminates views and bounds the leader's lead.

Repeat n is one block, with the same draws in every view still active, so what its views share cancels. With
M_i the mean of view i over the repeats before n, and bars over the active views, e_in = (y_in - ȳ_n) -
(M_i - M̄) gives the ragged table's error: SS = Σ_n (n - 1)/n Σ_i e_in² with ν = Σ_n (views active - 1) degrees
of freedom. Without elimination it is the residual of a randomised complete block design.

Let b be the best view. With the level's probability M_b - M_j ≥ (μ_b - μ_j) - w_bj for all j at every look;
then b is never eliminated, and no leader a is further behind it than U. Sources: J. C. Hsu, Multiple
Comparisons (1996), ch. 4 (comparison with the best); C. Jennison and B. W. Turnbull, Group Sequential Methods
(2000), ch. 9 (intervals that hold at every look).

Arrays may have leading axes, of many races at once; views that are not active may be NaN.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.stats.dunnett import quantile

_OWN = 4  # repeats that the pooled error is worth beside a pair's own


@dataclass(frozen=True)
class Rules:
    """Of a race.

    Attributes:
        first: repeats of every view before the first look.
        most: repeats after which it ends.
        tolerance: U at which it ends, in the values' unit.
        probability: tail of each look (:func:`pipeline.stats.tails.tail`).
    """

    first: int
    most: int
    tolerance: float
    probability: float


@dataclass(frozen=True)
class Error:
    """Sum of squares and degrees of freedom (…) of the repeats so far; s² = squares / df."""

    squares: np.ndarray
    df: np.ndarray

    @property
    def variance(self) -> np.ndarray:
        """s² (…), of one repeat's value; NaN without degrees of freedom."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.squares / self.df)


@dataclass(frozen=True)
class Look:
    """A race after ``repeats`` repeats.

    Attributes:
        repeats: how many each active view has.
        entered: (…, view) that were compared.
        active: (…, view) that are left.
        error: of one repeat.
        means: (…, view) over the repeats; NaN if not compared.
        variances: (…, view, view) v_ij of a difference in one repeat.
        half_widths: (…, view, view) w_ij; one-sided, they hold together and at every look.
        leader: (…) index of the active view with the highest mean.
        within: (…) U: the leader is the best or within this of it.
    """

    repeats: int
    entered: np.ndarray
    active: np.ndarray
    error: Error
    means: np.ndarray
    variances: np.ndarray
    half_widths: np.ndarray
    leader: np.ndarray
    within: np.ndarray


def no_error(shape: tuple[int, ...] = ()) -> Error:
    """Before the first repeat, of races of this shape."""
    return Error(np.zeros(shape), np.zeros(shape))


def with_repeat(error: Error, values: np.ndarray, active: np.ndarray) -> Error:
    """The error with one repeat more.

    Args:
        error: of the repeats before.
        values: (…, view, repeat) up to and with the new one, finite where active.
        active: (…, view) that have it.
    """
    repeats, count = values.shape[-1], active.sum(axis=-1)
    if repeats == 1:
        return error
    gap = np.where(active, values[..., -1] - values[..., :-1].mean(axis=-1), 0.0)
    e = np.where(active, gap - (gap.sum(axis=-1) / count)[..., None], 0.0)
    added = (repeats - 1) / repeats * (e**2).sum(axis=-1)
    return Error(error.squares + added, error.df + np.maximum(count - 1, 0))


def look(values: np.ndarray, entered: np.ndarray, error: Error, views: int, probability: float) -> Look:
    """Compares the views that have all repeats, and eliminates those that are not the best.

    Args:
        values: (…, view, repeat), finite where entered.
        entered: (…, view) those compared.
        error: with the last repeat.
        views: in the race at its start.
        probability: tail of one look (:func:`pipeline.stats.tails.tail`).
    """
    repeats = values.shape[-1]
    means = np.where(entered, values.mean(axis=-1), np.nan)
    variances = pair_variances(values, error)
    half = _quantiles(views - 1, error.df, probability)[..., None, None] * np.sqrt(variances / repeats)
    gaps = means[..., :, None] - means[..., None, :]  # (…, i, j): i less j
    active = entered & ~(gaps > half).any(axis=-2)  # NaN, of a view not entered, is never above
    leader = np.where(active, means, -np.inf).argmax(axis=-1)
    within = np.take_along_axis(half - gaps, leader[..., None, None], axis=-2)[..., 0, :]
    others = active & (np.arange(means.shape[-1]) != leader[..., None])
    behind = np.where(others, within, 0.0).max(axis=-1).clip(min=0.0)
    return Look(repeats, entered, active, error, means, variances, half, leader, behind)


def pair_variances(values: np.ndarray, error: Error) -> np.ndarray:
    """(…, view, view) v_ij = max(2 s², (8 s² + (n - 1) S²_ij) / (n + 3)) of one repeat's difference.

    S²_ij is the pair's own variance, shrunk towards the pooled one, which it never falls below; of two
    views it is that of the paired t-test. 0 on the diagonal.
    """
    repeats = values.shape[-1]
    differences = values[..., :, None, :] - values[..., None, :, :]
    own = differences.var(axis=-1, ddof=1)
    pooled = 2 * error.variance[..., None, None]
    shrunk = (_OWN * pooled + (repeats - 1) * own) / (repeats - 1 + _OWN)
    return np.where(np.eye(values.shape[-2], dtype=bool), 0.0, np.maximum(pooled, shrunk))


def _quantiles(comparisons: int, df: np.ndarray, probability: float) -> np.ndarray:
    different, place = np.unique(df, return_inverse=True)
    found = np.array([quantile(comparisons, float(one), probability) for one in different])
    return found[place].reshape(np.shape(df))
