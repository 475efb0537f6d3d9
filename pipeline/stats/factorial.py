"""Factorial effects of pan θ and tilt φ, where a scene's viewpoints form a full θ × φ grid.

Values are those of a randomised complete block design (:mod:`pipeline.stats.blocks`): repeat r is a block.
Its intervals are those of a fixed number of repeats; that a race may have chosen the number is not in them.
The error of every effect is the design's residual, s² with (V - 1)(R - 1) degrees of freedom.

Sources: D. C. Montgomery, Design and Analysis of Experiments, sections 4.1 and 5.3 (a factorial in
blocks); J. W. Tukey's studentized range for the levels of one factor; D. J. Schuirmann, J. Pharmacokin.
Biopharm. 15 (1987) 657-680 (two one-sided tests: "no difference" is an interval within a margin).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
from scipy import stats

from pipeline.stats.blocks import two_way
from pipeline.stats.f_tests import FTest, f_test

DIFFERS = "differs"
NO_DIFFERENCE = "no difference"
NOT_SETTLED = "not settled"
EQUIVALENCE_CONFIDENCE = 0.90  # of the interval that has to lie within the margin


@dataclass(frozen=True)
class Grid:
    """A full grid of viewpoints.

    Attributes:
        levels: of each factor (``theta``, ``phi``) its values in degrees, ascending.
        views: (θ, φ) the view at each place, an index into the table's rows.
    """

    levels: dict[str, list[float]]
    views: np.ndarray


@dataclass(frozen=True)
class Difference:
    """Between two levels of a factor.

    Attributes:
        factor: ``theta`` or ``phi``.
        first_deg, second_deg: the levels; the difference is first less second.
        difference, low, high: with its interval.
    """

    factor: str
    first_deg: float
    second_deg: float
    difference: float
    low: float
    high: float


@dataclass(frozen=True)
class Effect(Difference):
    """The mean at one level less that at another, over all levels of the other factor; Tukey's interval.

    Attributes:
        equivalence_low, equivalence_high: the 90 % t interval that is held against the margin.
        se: standard error of the difference.
        word: ``differs``, ``no difference`` or ``not settled``.
    """

    equivalence_low: float
    equivalence_high: float
    se: float
    word: str


@dataclass(frozen=True)
class Factorial:
    """All of it: the effects of both factors, their tests, and that of their interaction.

    Attributes:
        df_error: degrees of freedom of the error.
        margin: differences within ± this are none.
        tests: by ``theta``, ``phi`` (those with more than one level) and ``interaction`` (with both); none
            where the error is 0, which no mean square can be held against.
        effects: all pairs of levels, factor by factor.
    """

    df_error: float
    margin: float
    tests: dict[str, FTest]
    effects: list[Effect]


def find_grid(theta_deg: Sequence[float], phi_deg: Sequence[float]) -> Grid | None:
    """The grid that views at these angles form; ``None`` if they form none, or no factor varies.

    Of more views than a grid holds (a study beside the candidates), the largest full grid is taken, which
    is unique for a grid with views off it.
    """
    places = {(t, p): i for i, (t, p) in enumerate(zip(theta_deg, phi_deg, strict=True))}
    thetas, phis = sorted(set(theta_deg)), sorted(set(phi_deg))
    best: tuple[int, list[float], list[float]] = (1, [], [])
    for count in range(1, len(phis) + 1):
        for chosen in combinations(phis, count):
            full = [t for t in thetas if all((t, p) in places for p in chosen)]
            if len(full) * count > best[0]:
                best = (len(full) * count, full, list(chosen))
    if best[0] < 2:
        return None
    views = np.array([[places[t, p] for p in best[2]] for t in best[1]])
    return Grid({"theta": best[1], "phi": best[2]}, views)


def factorial(values: np.ndarray, grid: Grid, confidence: float, margin: float) -> Factorial | None:
    """Takes a table (view, repeat) apart; ``None`` with one repeat, which tells no error.

    Args:
        values: of all views that the grid indexes.
        grid: where they stand.
        confidence: level of the effects' intervals.
        margin: of equivalence, in the values' unit.
    """
    cells = values[grid.views]  # (θ, φ, repeat)
    fit = two_way(cells.reshape(-1, cells.shape[2]))
    if fit.residual is None:
        return None
    variance, df = fit.residual.sd**2, fit.residual.df
    effects = []
    for factor, (means, each) in _factors(cells).items():
        se = (2 * variance / each) ** 0.5
        effects += _pairs(factor, grid.levels[factor], means, se, df, confidence, margin)
    return Factorial(df, margin, _f_tests(cells, variance, df) if variance else {}, effects)


def _factors(cells: np.ndarray) -> dict[str, tuple[np.ndarray, int]]:
    """Of each factor that varies in cells (θ, φ, repeat): its levels' means, and the values behind each."""
    means = {factor: cells.mean(axis=(1 - axis, 2)) for axis, factor in enumerate(("theta", "phi"))}
    return {factor: (own, cells.size // len(own)) for factor, own in means.items() if len(own) > 1}


def _f_tests(cells: np.ndarray, variance: float, df: float) -> dict[str, FTest]:
    """The tests of cells (θ, φ, repeat) against an error's ``variance``, which is not 0."""
    tests = {}
    for factor, (means, each) in _factors(cells).items():
        tests[factor] = f_test(each * float(means.var(ddof=1)), len(means) - 1, variance, df)
    if len(tests) == 2:
        over = cells.mean(axis=2)
        left = over - over.mean(1, keepdims=True) - over.mean(0, keepdims=True) + over.mean()
        free = (over.shape[0] - 1) * (over.shape[1] - 1)
        tests["interaction"] = f_test(cells.shape[2] * float((left**2).sum()) / free, free, variance, df)
    return tests


def _pairs(
    factor: str,
    levels: Sequence[float],
    means: np.ndarray,
    se: float,
    df: float,
    confidence: float,
    margin: float,
) -> list[Effect]:
    half = studentized_range(confidence, len(means), df) * se / 2**0.5
    narrow = float(stats.t.ppf((1 + EQUIVALENCE_CONFIDENCE) / 2, df)) * se
    effects = []
    for first, second in combinations(range(len(means)), 2):
        gap = float(means[first] - means[second])
        bounds = (gap - half, gap + half, gap - narrow, gap + narrow)
        named = word(gap, half, narrow, margin)
        effects.append(Effect(factor, levels[first], levels[second], gap, *bounds, se, named))
    return effects


def word(difference: float, half_width: float, equivalence_half_width: float, margin: float) -> str:
    """What a difference is, from its interval and the 90 % interval that is held against the margin.

    A difference that is told from zero and yet within the margin is a difference.
    """
    if abs(difference) > half_width:
        return DIFFERS
    return NO_DIFFERENCE if abs(difference) + equivalence_half_width <= margin else NOT_SETTLED


@lru_cache(maxsize=256)
def studentized_range(confidence: float, means: int, df: float) -> float:
    """Tukey's quantile q for so many means; SciPy integrates again for each."""
    return float(stats.studentized_range.ppf(confidence, means, df))
