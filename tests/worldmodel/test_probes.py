"""Probes: exact where the answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.worldmodel.params import ProbeParams
from pipeline.worldmodel.probes import Labelled, probe

PARAMS = ProbeParams(hidden_units=32, steps=400, batch=128, learning_rate=0.01)


def _data(count: int, seed: int, curve: bool, noise_m: float = 0.0) -> Labelled:
    """Latents of which two move the target, the others are noise or dead; the tip stays in x."""
    rng = np.random.default_rng(seed)
    latents = rng.normal(size=(count, 32))
    latents[:, 5:] = 0.0
    place = latents[:, :1] ** 2 if curve else latents[:, :1]
    target = 0.1 * np.concatenate([place, latents[:, 1:2], 0 * place], axis=1)
    tip = 0.1 * np.concatenate([0 * place + 5, latents[:, 2:4]], axis=1)
    target += noise_m / np.sqrt(3) * rng.normal(size=target.shape)
    tip, target = tip.astype(np.float32), target.astype(np.float32)
    return Labelled(latents.astype(np.float32), tip, target, tip - target)


def test_a_linear_code_is_read_exactly() -> None:
    errors = probe(_data(400, 1, curve=False), _data(200, 2, curve=False), PARAMS, seed=1)
    for what in ("tip", "target", "tip_to_target"):
        assert errors[f"probe_linear_{what}_m"] < 1e-5
        assert errors[f"probe_mlp_{what}_m"] < 0.02


def test_noise_comes_out_in_metres() -> None:
    training, heldout = (_data(4000, seed, curve=False, noise_m=0.03) for seed in (1, 2))
    errors = probe(training, heldout, PARAMS, seed=1)
    assert errors["probe_linear_target_m"] == pytest.approx(0.03, rel=0.05)
    assert errors["probe_linear_tip_to_target_m"] == pytest.approx(0.03, rel=0.05)


def test_a_guess_errs_by_the_spread_of_what_it_guesses() -> None:
    training, heldout = (_data(4000, seed, curve=False) for seed in (1, 2))
    errors = probe(training, heldout, PARAMS, seed=1)
    assert errors["guess_tip_m"] == pytest.approx(0.1 * np.sqrt(2), rel=0.05)
    assert errors["guess_tip_to_target_m"] == pytest.approx(
        np.sqrt(errors["guess_tip_m"] ** 2 + errors["guess_target_m"] ** 2), rel=0.05
    )


def test_a_curved_code_needs_the_network() -> None:
    errors = probe(_data(4000, 1, curve=True), _data(300, 2, curve=True), PARAMS, seed=1)
    assert errors["probe_linear_target_m"] > 0.1
    assert errors["probe_mlp_target_m"] < 0.4 * errors["probe_linear_target_m"]


def test_the_same_seed_gives_the_same_errors() -> None:
    data = _data(100, 1, curve=True), _data(50, 2, curve=True)
    assert probe(*data, PARAMS, seed=1) == probe(*data, PARAMS, seed=1)
    assert probe(*data, PARAMS, seed=1) != probe(*data, PARAMS, seed=2)
