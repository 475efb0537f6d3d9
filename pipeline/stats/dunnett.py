"""Dunnett's one-sided quantile.

C. W. Dunnett, J. Am. Stat. Assoc. 50 (1955) 1096-1121: k - 1 differences from one mean, equally
correlated (½), over a common standard error with ν degrees of freedom.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy import optimize, special, stats

_NODES, _MIDPOINTS = 61, 96
_LARGEST = 1e6


@lru_cache(maxsize=4096)
def quantile(comparisons: int, df: float, probability: float) -> float:
    """c with P(some of the comparisons' t exceeds c) = ``probability``, all means being equal.

    Solves 1 - E_s E_Z[Φ(√2 c s + Z)^comparisons] = p with s² ~ χ²_ν / ν, Z standard normal. Of one
    comparison it is Student's quantile; of none it is 0.

    Args:
        comparisons: with the one mean, views less one.
        df: degrees of freedom ν of the standard error.
        probability: one-sided, for all comparisons together.
    """
    if comparisons == 0:
        return 0.0
    if comparisons == 1:
        return float(stats.t.isf(probability, df))
    z, weights = np.polynomial.hermite_e.hermegauss(_NODES)
    middles = (np.arange(_MIDPOINTS) + 0.5) / _MIDPOINTS
    s = np.sqrt(stats.chi2.ppf(middles, df) / df)

    def excess(c: float) -> float:
        below = special.ndtr(2**0.5 * c * s[:, None] + z) ** comparisons
        return 1 - float((below @ weights).mean() / weights.sum()) - probability

    return float(optimize.brentq(excess, 0.0, _LARGEST, xtol=1e-9))
