"""The VAE's benchmark compares like with like."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from benchmarks.vae import loss_after, ours, peer

PICTURES = np.random.default_rng(1).integers(0, 256, (64, 64, 64, 3), dtype=np.uint8)


def test_both_start_from_the_same_weights_whatever_the_seed() -> None:
    first, second = ours(PICTURES, 1)[0].state_dict(), peer(PICTURES, 2)[0].state_dict()
    assert all(torch.equal(weight, second[name]) for name, weight in first.items())


def test_the_same_steps_lead_to_the_same_loss(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BELVEDERE_DTYPE", "float32")
    mine, theirs = (loss_after(2, *make(PICTURES, 1), PICTURES) for make in (ours, peer))
    begun = loss_after(0, *peer(PICTURES, 1), PICTURES)
    assert theirs < 0.99 * begun  # it has learned something, so that the comparison says something
    assert mine == pytest.approx(theirs, rel=1e-4)
    assert loss_after(2, *peer(PICTURES, 3), PICTURES) != pytest.approx(theirs, rel=1e-5)
