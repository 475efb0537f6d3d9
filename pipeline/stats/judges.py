"""Two judges of the same viewpoints: does what a viewpoint gives depend on who judges?

A significant difference for one judge and none for the other are not a difference between judges, so
the interaction is tested itself. Judges are trained independently, each in its own blocks, with
residual variances of their own; their sum has Satterthwaite's degrees of freedom (as in Welch's test).

Sources: B. L. Welch, Biometrika 34 (1947) 28-35; F. E. Satterthwaite, Biometrics Bulletin 2 (1946)
110-114; S. Holm, Scand. J. Statist. 6 (1979) 65-70; A. Gelman and H. Stern, Am. Stat. 60 (2006) 328-331.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from pipeline.stats.blocks import two_way
from pipeline.stats.f_tests import FTest, f_test
from pipeline.stats.factorial import Difference, Effect, Factorial


@dataclass(frozen=True)
class EffectByJudge(Difference):
    """How much more a step between two levels changes the score of the first judge than of the second.

    The interval is Welch's.

    Attributes:
        p: two-sided, adjusted over all effects by Holm's method.
    """

    p: float


def judge_by_view(first: np.ndarray, second: np.ndarray) -> FTest | None:
    """Tests whether the judges' view means differ by more than a constant.

    With d the difference of the judges' view means, F = Σ (d - d̄)² / (V - 1) / (s₁²/R₁ + s₂²/R₂).

    Args:
        first: (view, repeat) of one judge.
        second: the same views of the other; repeats may differ in number.

    Returns:
        The test, or ``None`` where one judge or view tells no error, or both judges' error is 0.
    """
    fits = [two_way(first), two_way(second)]
    if any(fit.residual is None for fit in fits):
        return None
    parts = np.array([fit.residual.sd**2 / fit.repeats for fit in fits if fit.residual])
    free = np.array([fit.residual.df for fit in fits if fit.residual])
    if not parts.any():
        return None
    gaps = fits[0].means - fits[1].means
    df, df_error = len(gaps) - 1, _satterthwaite(parts, free)
    return f_test(float(gaps.var(ddof=1)), df, float(parts.sum()), df_error)


def effects_by_judge(first: Factorial, second: Factorial, confidence: float) -> list[EffectByJudge]:
    """The same effects of two judges, held against each other one by one."""
    pairs = list(zip(first.effects, second.effects, strict=True))
    tested = [_compared(a, b, first.df_error, second.df_error, confidence) for a, b in pairs]
    adjusted = holm([p for _, _, p in tested])
    return [
        EffectByJudge(a.factor, a.first_deg, a.second_deg, gap, gap - half, gap + half, p)
        for (a, _), (gap, half, _), p in zip(pairs, tested, adjusted, strict=True)
    ]


def holm(p_values: Sequence[float]) -> list[float]:
    """Holm's adjusted p-values, in the given order."""
    order = np.argsort(p_values, kind="stable")
    adjusted, highest = np.zeros(len(p_values)), 0.0
    for place, index in enumerate(order):
        highest = max(highest, min(1.0, (len(p_values) - place) * p_values[index]))
        adjusted[index] = highest
    return [float(p) for p in adjusted]


def _compared(
    first: Effect, second: Effect, df_first: float, df_second: float, confidence: float
) -> tuple[float, float, float]:
    """Difference of two effects, half its interval, and its p-value."""
    parts = np.array([first.se**2, second.se**2])
    df, se = _satterthwaite(parts, np.array([df_first, df_second])), float(parts.sum()) ** 0.5
    gap = first.difference - second.difference
    p = float(2 * stats.t.sf(abs(gap) / se, df)) if se else float(gap == 0)
    return gap, float(stats.t.ppf((1 + confidence) / 2, df)) * se, p


def _satterthwaite(variances: np.ndarray, df: np.ndarray) -> float:
    """Degrees of freedom of a sum of estimated variances."""
    spread = float((variances**2 / df).sum())
    return float(variances.sum() ** 2 / spread) if spread else float(df.sum())
