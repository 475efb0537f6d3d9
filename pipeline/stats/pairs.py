"""All pairs of a scene's views: differences, effect sizes, the paper's own test, repeats that would tell.

Sources: L. V. Hedges, J. Educ. Stat. 6 (1981) 107-128 (g and its correction J); B. L. Welch, Biometrika
34 (1947) 28-35; J. Cohen, Statistical Power Analysis (1988), with the noncentral t distribution.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy import special, stats

from pipeline.stats.blocks import TwoWay, difference_half_width, studentized_range
from pipeline.stats.branches import Results
from pipeline.stats.params import RankingParams

POWER = 0.8
MOST_REPEATS = 1000
_CERTAIN = 8.0


@dataclass(frozen=True)
class Pair:
    """One view less another.

    Attributes:
        first, second: the views' names.
        difference, low, high: of their means, with Tukey's interval over all pairs.
        hedges_g: the difference in standard deviations of a training, pooled over the scene's views and
            corrected for few repeats.
        welch_p: two-sided, of Welch's two-sample t-test of these two views alone, as the paper tests.
        repeats_needed: repeats at which a true gap as large as the one seen would be told apart with
            80 % power; ``None`` above 1000.
    """

    first: str
    second: str
    difference: float
    low: float
    high: float
    hedges_g: float
    welch_p: float
    repeats_needed: int | None


@dataclass(frozen=True)
class Gap:
    """A difference between views that is worth caring about.

    Attributes:
        score: of normalised scores.
        metres: the same of returns.
        repeats_needed: to tell it with 80 % power; ``None`` above 1000, or where nothing tells the error.
    """

    score: float
    metres: float
    repeats_needed: int | None


def pairs(keys: Sequence[str], values: np.ndarray, fit: TwoWay, confidence: float) -> list[Pair]:
    """All pairs of views of a table (view, repeat) with its fit; none with one view or repeat."""
    half = difference_half_width(fit, confidence)
    if half is None or fit.within is None or fit.residual is None:
        return []
    found = []
    for first, second in combinations(range(len(values)), 2):
        gap = float(fit.means[first] - fit.means[second])
        welch = stats.ttest_ind(values[first], values[second], equal_var=False)
        found.append(
            Pair(
                keys[first],
                keys[second],
                gap,
                gap - half,
                gap + half,
                hedges_g(gap, fit.within.sd, fit.within.df),
                float(welch.pvalue),
                repeats_needed(abs(gap), fit.residual.sd, len(values), confidence),
            )
        )
    return found


def needed_between(found: Sequence[Pair], views: set[str]) -> int | None:
    """Repeats at which these two views would be told apart at the gap seen; ``None`` where nobody knows."""
    return next((pair.repeats_needed for pair in found if {pair.first, pair.second} == views), None)


def gap_worth_caring(results: Results, fit: TwoWay, params: RankingParams) -> Gap:
    """What it takes to tell a gap that somebody would act on: the margin of equivalence."""
    anchors = results.anchors
    metres = params.equivalence_margin * float((anchors["expert"] - anchors["blind"]).mean())
    if fit.residual is None:
        return Gap(params.equivalence_margin, metres, None)
    needed = repeats_needed(metres, fit.residual.sd, len(fit.means), params.confidence)
    return Gap(params.equivalence_margin, metres, needed)


def hedges_g(difference: float, sd: float, df: float) -> float:
    """A difference in standard deviations, times J(df) = Γ(df/2) / (√(df/2) Γ((df - 1)/2))."""
    if df <= 1 or not sd:
        return float("nan") if not sd else difference / sd
    log_j = special.gammaln(df / 2) - special.gammaln((df - 1) / 2) - 0.5 * np.log(df / 2)
    return float(difference / sd * np.exp(log_j))


def power(gap: float, sd: float, views: int, repeats: int, confidence: float) -> float:
    """The chance that Tukey's interval of a pair with a true difference ``gap`` leaves out zero.

    Args:
        gap: the true difference.
        sd: residual standard deviation of one repeat.
        views: how many are compared.
        repeats: how many there are of each.
        confidence: of the intervals.
    """
    df = (views - 1) * (repeats - 1)
    critical = studentized_range(confidence, views, df) / 2**0.5
    shift = gap / (sd * (2 / repeats) ** 0.5)
    if shift > critical + _CERTAIN:  # SciPy's noncentral t gives no number so far out
        return 1.0
    return float(stats.nct.sf(critical, df, shift) + stats.nct.cdf(-critical, df, shift))


def repeats_needed(gap: float, sd: float, views: int, confidence: float) -> int | None:
    """The fewest repeats with 80 % power at ``gap``; ``None`` if 1000 are too few."""

    def enough(repeats: int) -> bool:
        return power(gap, sd, views, repeats, confidence) >= POWER

    high = 2
    while not enough(high):  # power rises with repeats
        high *= 2
        if not gap or high > 2 * MOST_REPEATS:
            return None
    low = high // 2
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high if high <= MOST_REPEATS else None
