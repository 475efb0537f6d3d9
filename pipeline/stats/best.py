"""How likely each view is the best, were the trainings repeated without end.

The model of :mod:`pipeline.stats.blocks` with a flat prior on the views' means and on log σ: given the
table, σ² is df s² over a χ² with df degrees of freedom, and what remains of a mean once the repeats'
shifts cancel is normal about the mean seen, with variance σ² / R (G. E. P. Box and G. C. Tiao, Bayesian
Inference in Statistical Analysis (1973), section 2.11).
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from pipeline.stats.blocks import TwoWay

_SIGMAS, _PLACES = 128, 201


def chance_of_best(fit: TwoWay) -> list[float] | None:
    """P(best) of each view; they sum to 1. ``None`` where nothing tells the error.

    For view i it is the mean over σ of ∫ φ(x) Π_j Φ(x + (m_i - m_j) √R / σ) dx, by quadrature.
    """
    if fit.residual is None:
        return None
    if fit.residual.sd == 0:
        return [float(view == int(np.argmax(fit.means))) for view in range(len(fit.means))]
    shares = (np.arange(_SIGMAS) + 0.5) / _SIGMAS
    sigmas = fit.residual.sd * np.sqrt(fit.residual.df / stats.chi2.ppf(shares, fit.residual.df))
    x = np.linspace(-7, 7, _PLACES)
    weights = stats.norm.pdf(x)
    gaps = (fit.means[:, None] - fit.means) * fit.repeats**0.5  # (i, j)
    below = stats.norm.cdf(x + gaps[:, :, None, None] / sigmas[:, None])  # (i, j, σ, x)
    below[np.arange(len(gaps)), np.arange(len(gaps))] = 1.0
    chances = (below.prod(axis=1) * weights).sum(axis=2).mean(axis=1)
    return [float(chance) for chance in chances / chances.sum()]
