"""P(best) against a closed form and a simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.best import chance_of_best
from pipeline.stats.blocks import two_way


def test_of_two_views_it_is_a_t_probability() -> None:
    values = np.random.default_rng(1).normal(size=(2, 4)) + np.array([[0.4], [0.0]])
    fit = two_way(values)
    chances = chance_of_best(fit)
    gaps = values[0] - values[1]
    expected = stats.t.cdf(gaps.mean() / (gaps.std(ddof=1) / 2), 3)
    assert chances == pytest.approx([expected, 1 - expected], abs=2e-3)


def test_of_many_views_it_is_what_draws_of_the_model_show() -> None:
    values = np.random.default_rng(2).normal(size=(5, 3)) + np.array([0.9, 0.6, 0.0, 0.0, -2.0])[:, None]
    fit, rng, draws = two_way(values), np.random.default_rng(3), 200_000
    assert fit.residual is not None
    sigma = fit.residual.sd * np.sqrt(fit.residual.df / rng.chisquare(fit.residual.df, draws))
    means = fit.means + sigma[:, None] / 3**0.5 * rng.standard_normal((draws, 5))
    expected = np.bincount(means.argmax(axis=1), minlength=5) / draws
    assert chance_of_best(fit) == pytest.approx(expected, abs=5e-3)


def test_without_an_error_there_is_none_and_without_scatter_no_doubt() -> None:
    assert chance_of_best(two_way(np.zeros((3, 1)))) is None
    assert chance_of_best(two_way(np.array([[1.0, 1.0], [2.0, 2.0]]))) == [0.0, 1.0]
