"""Correlated actions: their law, against the closed form of the process."""

from __future__ import annotations

import numpy as np

from pipeline.sim.exploration import correlated_actions
from pipeline.sim.params import ExplorationParams


def test_autocorrelation_and_deviation_are_the_processs() -> None:
    process = ExplorationParams(correlation=0.9, deviation=0.2)  # small enough to be clipped hardly ever
    actions = correlated_actions((4000, 50, 2), process, np.random.default_rng(0)).astype(float)
    assert abs(actions.std() - 0.2) < 0.01
    for lag in (1, 5):
        measured = np.mean(actions[:, :-lag] * actions[:, lag:]) / actions.var()
        assert abs(measured - 0.9**lag) < 0.02


def test_actions_are_bounded_and_seeded() -> None:
    process = ExplorationParams(correlation=0.5, deviation=3.0)
    first, second = (correlated_actions((5, 50, 3), process, np.random.default_rng(7)) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert np.abs(first).max() == 1.0
