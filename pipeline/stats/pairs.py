"""All pairs of a scene's views: differences, effect sizes, the paper's own test, repeats that would tell.

Sources: L. V. Hedges, J. Educ. Stat. 6 (1981) 107-128 (g and its correction J); B. L. Welch, Biometrika
34 (1947) 28-35; J. Cohen, Statistical Power Analysis (1988), with the noncentral t distribution.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np
from scipy import special, stats

from pipeline.stats.blocks import TwoWay, difference_half_width, studentized_range

POWER = 0.8
MOST_REPEATS = 1000
_CERTAIN = 8.0


@dataclass(frozen=True)
class Pair:
    """One view less another.

    Attributes:
        first, second: places of the views in the table.
        difference, low, high: of their means, with Tukey's interval over all pairs.
        hedges_g: the difference in standard deviations of a training, pooled over the scene's views and
            corrected for few repeats.
        welch_p: two-sided, of Welch's two-sample t-test of these two views alone, as the paper tests.
        repeats_needed: repeats at which a true gap as large as the one seen would be told apart with
            80 % power; ``None`` above 1000.
    """

    first: int
    second: int
    difference: float
    low: float
    high: float
    hedges_g: float
    welch_p: float
    repeats_needed: int | None


def pairs(values: np.ndarray, fit: TwoWay, confidence: float) -> list[Pair]:
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
                first,
                second,
                gap,
                gap - half,
                gap + half,
                hedges_g(gap, fit.within.sd, fit.within.df),
                float(welch.pvalue),
                repeats_needed(abs(gap), fit.residual.sd, len(values), confidence),
            )
        )
    return found


def named(found: list[Pair], keys: list[str]) -> list[dict[str, Any]]:
    """The pairs as plain tables, with the branches' names."""
    return [{**asdict(pair), "first": keys[pair.first], "second": keys[pair.second]} for pair in found]


def needed_for_first_two(found: list[Pair], fit: TwoWay) -> int | None:
    """Repeats at which the two views of the highest means would be told apart at the gap seen."""
    first_two = {int(index) for index in np.argsort(-fit.means, kind="stable")[:2]}
    return next((pair.repeats_needed for pair in found if {pair.first, pair.second} == first_two), None)


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
