"""The surface on the sphere: its covariance, its limits, and a seam that is none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import special, stats

from pipeline.stats import surface as module
from pipeline.stats.surface import distances, grid, matern, surface, unit_vectors


def test_matern_is_the_general_one_at_five_halves() -> None:
    """Rasmussen and Williams, eq. (4.14), with the modified Bessel function."""
    d, nu = np.linspace(0.05, 3, 20), 2.5
    scaled = (2 * nu) ** 0.5 * d
    general = 2 ** (1 - nu) / special.gamma(nu) * scaled**nu * special.kv(nu, scaled)
    assert matern(d) == pytest.approx(general, rel=1e-10)


def test_distances_are_chords() -> None:
    a, b = unit_vectors([(0, 0), (90, 0)]), unit_vectors([(0, 0), (0, 90)])
    assert distances(a, b) == pytest.approx(np.array([[0, 2**0.5], [2**0.5, 2**0.5]]), abs=1e-7)


def test_with_one_set_of_hyperparameters_it_is_the_normal_s_conditional(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Against the conditional of the joint normal, by its precision matrix."""
    for name, value in (("LENGTHS", (0.6,)), ("SIGNALS", (0.2,)), ("NOISES", (0.04,))):
        monkeypatch.setattr(module, name, value)
    rng = np.random.default_rng(2)
    tried = unit_vectors([(0, 10), (40, 20), (40, 20), (-60, 50)])
    repeats, scores = np.array([0, 0, 1, 0]), rng.random(4)
    at = unit_vectors([(10, 15), (-60, 50)])
    found = surface(tried, repeats, scores, at)
    everywhere = np.concatenate([at, tried])
    joint = 0.2**2 * matern(distances(everywhere, everywhere) / 0.6) + module._LEVEL**2
    joint[2:, 2:] += module._BLOCK**2 * (repeats[:, None] == repeats) + 0.04**2 * np.eye(4)
    precision = np.linalg.inv(joint)
    conditional = np.linalg.inv(precision[:2, :2])
    mean = module._CENTRE - conditional @ precision[:2, 2:] @ (scores - module._CENTRE)
    assert found.mean == pytest.approx(mean, rel=1e-8)
    assert found.sd == pytest.approx(np.sqrt(np.diag(conditional)), rel=1e-6)


def test_hyperparameters_weigh_by_the_likelihood(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where two noises are tried, the mean lies between theirs, at the share that scipy's densities give."""
    tried, repeats = unit_vectors([(0, 0), (50, 0), (100, 0)]), np.zeros(3, dtype=int)
    scores, at = np.array([0.4, 0.8, 0.5]), unit_vectors([(20, 0)])
    monkeypatch.setattr(module, "LENGTHS", (0.6,))
    monkeypatch.setattr(module, "SIGNALS", (0.2,))
    alone, weights = [], []
    for noise in (0.02, 0.3):
        monkeypatch.setattr(module, "NOISES", (noise,))
        alone.append(surface(tried, repeats, scores, at).mean[0])
        covariance = 0.2**2 * matern(distances(tried, tried) / 0.6) + module._BLOCK**2 + module._LEVEL**2
        normal = stats.multivariate_normal(np.full(3, module._CENTRE), covariance + noise**2 * np.eye(3))
        weights.append(normal.pdf(scores))
    monkeypatch.setattr(module, "NOISES", (0.02, 0.3))
    expected = np.average(alone, weights=weights)
    assert surface(tried, repeats, scores, at).mean[0] == pytest.approx(expected, rel=1e-6)


def test_there_is_no_seam_at_a_full_turn_and_none_at_the_pole() -> None:
    rng = np.random.default_rng(3)
    places = [(theta, phi) for theta in range(-180, 180, 40) for phi in (10, 50)]
    scores = rng.random(len(places))
    at = unit_vectors([(180, 20), (-180, 20), (0, 89.999), (120, 89.999)])
    found = surface(unit_vectors(places), np.zeros(len(places), dtype=int), scores, at)
    assert found.mean[0] == pytest.approx(found.mean[1], abs=1e-12)
    assert found.mean[2] == pytest.approx(found.mean[3], abs=1e-3)


def test_what_all_views_of_a_repeat_share_is_no_part_of_the_map() -> None:
    places = unit_vectors([(t, 20) for t in (-80, -40, 0, 40, 80)] * 2)
    repeats = np.repeat([0, 1], 5)
    truth = np.tile([0.5, 0.6, 0.7, 0.6, 0.5], 2)
    plain = surface(places, repeats, truth, places[:5])
    shifted = surface(places, repeats, truth + np.where(repeats == 1, 0.1, 0.0), places[:5])
    assert np.ptp(shifted.mean - plain.mean) < 0.01


def test_it_is_unsure_far_from_trainings() -> None:
    found = surface(
        unit_vectors([(0, 20), (20, 20), (40, 40)]), np.zeros(3, dtype=int), np.array([0.5, 0.7, 0.6]),
        unit_vectors([(0, 20), (180, -20)]),
    )  # fmt: skip
    assert found.sd[1] > 1.5 * found.sd[0]


def test_the_grid_covers_the_range_every_five_degrees() -> None:
    found = grid([(-88, 1), (31, 62)])
    theta, phi = found.T
    assert (theta.min(), theta.max(), phi.min(), phi.max()) == (-90, 35, 0, 65)
    assert len(found) == 26 * 14
