"""The latents stage: each frame's posterior, by that repeat's own network."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from pipeline import latents
from pipeline.contract.errors import BelvedereError
from pipeline.learning import checkpoints
from pipeline.learning.device import Compute
from pipeline.learning.training import seeded
from pipeline.storage import zarrs
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.vae_training import initialised
from tests.stages.worldmodel_stages import write_frames
from tests.stores import random_frames


@pytest.fixture(autouse=True)
def _float32(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BELVEDERE_DTYPE", "float32")
    monkeypatch.setenv("BELVEDERE_CORES", "2")


def test_each_repeat_is_encoded_by_its_own_network(tmp_path: Path) -> None:
    write_frames(tmp_path / "frames", repeats=2)
    networks = [initialised(seeded(repeat)) for repeat in range(2)]
    for repeat, network in enumerate(networks):
        checkpoints.save(tmp_path / f"repeat_{repeat}.pt", network.state_dict())
    latents.main(frames=tmp_path / "frames", vae=tmp_path, out=tmp_path / "latents")
    frames = zarrs.Store(tmp_path / "frames", zarrs.FRAMES, "frames")
    store = zarrs.Store(tmp_path / "latents", zarrs.LATENTS, "latents")
    assert store.attributes == frames.attributes
    for repeat, network in enumerate(networks):
        pictures = torch.from_numpy(frames.repeat("rgb", repeat)[1]).permute(0, 3, 1, 2).float() / 255
        with torch.inference_mode():
            mean, log_variance = network.encode(pictures)
        np.testing.assert_allclose(store.repeat("mean", repeat)[1], mean, atol=1e-5)
        np.testing.assert_allclose(store.repeat("log_variance", repeat)[1], log_variance, atol=1e-5)
        assert np.array_equal(store.repeat("action", repeat), frames.repeat("action", repeat))


def test_a_missing_network_is_named(tmp_path: Path) -> None:
    write_frames(tmp_path / "frames", repeats=1)
    with pytest.raises(BelvedereError, match=r"repeat_0\.pt is missing; `dvc repro vae`"):
        latents.main(frames=tmp_path / "frames", vae=tmp_path, out=tmp_path / "latents")
    assert not (tmp_path / "latents").exists()


def test_parts_give_the_codes_of_the_whole_to_the_bit(tmp_path: Path) -> None:
    """70 episodes of 12 frames: batches of 256 pictures end within episodes, parts of 64 do not."""
    store = random_frames(tmp_path / "frames", 70, 12)
    encoder = Encoder(initialised(seeded(1)), Compute(torch.device("cpu"), torch.float32))
    found = latents.encode(store, 0, encoder)
    whole = encoder.posterior(store.repeat("rgb", 0).reshape(-1, 64, 64, 3))
    for name, expected in zip(("mean", "log_variance"), whole, strict=True):
        np.testing.assert_array_equal(found[name].reshape(-1, 32), expected.numpy())
