"""The frozen encoder: the VAE's own posterior, from bytes."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from pipeline.learning.device import Compute
from pipeline.learning.training import seeded
from pipeline.worldmodel import encoder
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.vae_training import initialised

BYTES = np.random.default_rng(1).integers(0, 256, (20, 64, 64, 3), dtype=np.uint8)


@pytest.mark.parametrize(("dtype", "error"), [(torch.float32, 1e-5), (torch.bfloat16, 0.05)])
def test_it_is_the_vaes_posterior(dtype: torch.dtype, error: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(encoder, "BATCH", 8)  # so that the pictures make several batches
    vae = initialised(seeded(1))
    place = Compute(torch.device("cpu"), dtype)
    with torch.inference_mode():
        expected = vae.encode(torch.from_numpy(BYTES).permute(0, 3, 1, 2).float() / 255)
    for mine, theirs in zip(Encoder(vae, place).posterior(BYTES), expected, strict=True):
        assert mine.dtype == torch.float32
        assert float((mine - theirs).abs().max()) < error * float(theirs.abs().max())
