"""Two views against each other: the tests of a study with people, each with an effect size and its interval.

Differences are the first view less the second; of times and distances less is better.

Sources: the two-sample t-test is the paper's (section IV-D). Intervals of standardised differences invert the
noncentral t: G. Cumming and S. Finch, Educ. Psychol. Meas. 61 (2001) 532-574. The correction for few people
is L. V. Hedges', J. Educ. Stat. 6 (1981) 107-128. Signed ranks: M. Hollander, D. A. Wolfe and E. Chicken,
Nonparametric Statistical Methods, 3rd ed. (2014), sections 3.1 to 3.3.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy import optimize, special, stats


@dataclass(frozen=True)
class TTest:
    """A t-test of a difference of means.

    Attributes:
        difference, low, high: of the means, in the measure's unit, with its interval.
        t, df, p: statistic, degrees of freedom, two-sided p-value.
        effect, effect_low, effect_high: the difference in standard deviations, with its interval: of two
            samples Hedges' g by the pooled one, of pairs Cohen's d_z by that of the differences.
    """

    difference: float
    low: float
    high: float
    t: float
    df: float
    p: float
    effect: float
    effect_low: float
    effect_high: float


@dataclass(frozen=True)
class SignedRanks:
    """Wilcoxon's signed-rank test of pairs.

    Attributes:
        w, p: the smaller sum of ranks, and the two-sided p-value.
        shift, low, high: Hodges and Lehmann's estimate of the difference, with its interval; ``None`` where
            so few pairs have none of that level.
        effect: matched-pairs rank-biserial correlation: share of the ranks that speak for a larger first less
            the share that speaks against.
    """

    w: float
    p: float
    shift: float
    low: float | None
    high: float | None
    effect: float


def two_sample(first: np.ndarray, second: np.ndarray, alpha: float) -> TTest | None:
    """Student's t-test of independent samples (n,) and (m,), as in the paper; ``None`` where it says nothing:
    fewer than two in a sample, or no spread."""
    n, m = len(first), len(second)
    if min(n, m) < 2:
        return None
    df = n + m - 2
    pooled = np.sqrt(((n - 1) * np.var(first, ddof=1) + (m - 1) * np.var(second, ddof=1)) / df)
    if not pooled > 0:
        return None
    per_sd = float(np.sqrt(1 / n + 1 / m))  # standard error of a difference of means of unit spread
    return _t_test(float(np.mean(first) - np.mean(second)), float(pooled), per_sd, df, alpha, _hedges(df))


def paired(first: np.ndarray, second: np.ndarray, alpha: float) -> TTest | None:
    """Student's t-test of pairs (n,), (n,); ``None`` with fewer than two, or where all differ by the same."""
    gaps = np.asarray(first) - np.asarray(second)
    sd = float(np.std(gaps, ddof=1)) if len(gaps) > 1 else 0.0
    if not sd > 1e-12 * float(np.abs(gaps).max(initial=0.0)):
        return None
    return _t_test(float(gaps.mean()), sd, 1 / float(np.sqrt(len(gaps))), len(gaps) - 1, alpha, 1.0)


def signed_ranks(first: np.ndarray, second: np.ndarray, alpha: float) -> SignedRanks | None:
    """Wilcoxon's test of pairs (n,), (n,), equal ones left out; ``None`` with fewer than two that differ."""
    gaps = np.asarray(first) - np.asarray(second)
    gaps = gaps[gaps != 0]
    n = len(gaps)
    if n < 2:
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that ties make SciPy's p-value approximate
        found = stats.wilcoxon(gaps)
    ranks = stats.rankdata(np.abs(gaps))
    walsh = np.sort([(gaps[i] + gaps[j]) / 2 for i in range(n) for j in range(i, n)])
    low, high = _walsh_interval(walsh, n, alpha)
    effect = float((np.sign(gaps) * ranks).sum() / ranks.sum())
    return SignedRanks(
        float(found.statistic), float(found.pvalue), float(np.median(walsh)), low, high, effect
    )


def shift_interval(t: float, df: float, alpha: float) -> tuple[float, float]:
    """The noncentralities under which a t as extreme as this, to either side, has probability alpha / 2."""
    if t < 0:
        low, high = shift_interval(-t, df, alpha)
        return -high, -low
    return _shift(t, df, 1 - alpha / 2), _shift(t, df, alpha / 2)


def _shift(t: float, df: float, share: float) -> float:
    """The noncentrality at which the share lies below a t that is not negative."""

    def above(shift: float) -> float:
        below = special.nctdtr(df, shift, t)
        if np.isnan(below):  # SciPy's answer far out in a tail
            below = 1.0 if shift < t else 0.0
        return float(below - share)

    step = -1.0 if above(t) < 0 else 1.0
    end = t + step
    while above(end) * step > 0:
        step *= 2
        end = t + step
    return float(optimize.brentq(above, min(t, end), max(t, end), xtol=1e-10))


def _t_test(gap: float, sd: float, per_sd: float, df: float, alpha: float, correction: float) -> TTest:
    se = sd * per_sd
    t, half = gap / se, float(stats.t.isf(alpha / 2, df)) * se
    low, high = (correction * c * per_sd for c in shift_interval(t, df, alpha))
    p = float(2 * stats.t.sf(abs(t), df))
    return TTest(gap, gap - half, gap + half, t, df, p, correction * gap / sd, low, high)


def _hedges(df: float) -> float:
    """What makes the standardised difference of two samples unbiased."""
    logs = special.gammaln(df / 2) - special.gammaln((df - 1) / 2)
    return float(np.exp(logs) / np.sqrt(df / 2)) if df > 1 else 1.0


def _walsh_interval(walsh: np.ndarray, n: int, alpha: float) -> tuple[float | None, float | None]:
    """The order statistics of the Walsh averages that the exact signed-rank distribution names."""
    counts = np.ones(1)
    for rank in range(1, n + 1):
        counts = np.convolve(counts, np.r_[1.0, np.zeros(rank - 1), 1.0]) / 2
    below = int(np.searchsorted(np.cumsum(counts), alpha / 2, side="right"))  # sums that are too small
    if below == 0:
        return None, None
    return float(walsh[below - 1]), float(walsh[-below])
