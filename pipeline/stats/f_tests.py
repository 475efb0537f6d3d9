"""F tests: a mean square held against an error's."""

from __future__ import annotations

from dataclasses import dataclass

from scipy import stats


@dataclass(frozen=True)
class FTest:
    """An F test: numerator and denominator degrees of freedom, statistic and p-value."""

    df: float
    df_error: float
    f: float
    p: float


def f_test(mean_square: float, df: float, error: float, df_error: float) -> FTest:
    """Holds a mean square with ``df`` degrees of freedom against ``error``, which is not 0."""
    f = mean_square / error
    return FTest(df, df_error, f, float(stats.f.sf(f, df, df_error)))
