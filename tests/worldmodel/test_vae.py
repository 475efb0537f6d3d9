"""The VAE: Ha and Schmidhuber's parameters and function, computed another way."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
import torch.nn.functional as F
from torch.distributions import Normal, kl_divergence

from benchmarks.vae import PublishedVae, published
from pipeline.contract.errors import BelvedereError
from pipeline.learning import checkpoints
from pipeline.learning.training import seeded
from pipeline.worldmodel.vae import Vae, kl_nats, load_vae
from pipeline.worldmodel.vae_training import initialised


@pytest.fixture(scope="module")
def both() -> tuple[Vae, PublishedVae]:
    draws = seeded(1)
    ours = initialised(draws)
    with torch.no_grad():  # biases that are not zero, so that a misplaced one shows
        for weight in ours.parameters():
            weight.add_(0.02 * torch.randn(weight.shape, generator=draws))
    return ours, published(ours)


def test_the_published_number_of_parameters() -> None:
    assert sum(weight.numel() for weight in Vae().parameters()) == 4_348_547


def test_values_equal_those_of_the_published_form(both: tuple[Vae, PublishedVae]) -> None:
    ours, theirs = both
    pictures, latents = torch.rand(5, 3, 64, 64, generator=seeded(2)), torch.randn(5, 32, generator=seeded(3))
    with torch.inference_mode():
        for mine, expected in zip(ours.encode(pictures), theirs.encode(pictures), strict=True):
            torch.testing.assert_close(mine, expected, rtol=1e-4, atol=1e-5)
        torch.testing.assert_close(ours.decode(latents), theirs.decode(latents), rtol=1e-4, atol=1e-5)


def test_gradients_equal_those_of_the_published_form(both: tuple[Vae, PublishedVae]) -> None:
    pictures = torch.rand(3, 3, 64, 64, generator=seeded(2))
    gradients = []
    for vae in both:
        mean, log_variance = vae.encode(pictures)
        loss = F.mse_loss(vae.decode(mean + log_variance), pictures, reduction="sum")
        gradients.append(torch.autograd.grad(loss, list(vae.parameters())))
    for mine, expected in zip(*gradients, strict=True):
        scale = float(expected.abs().max())
        torch.testing.assert_close(mine, expected, rtol=1e-3, atol=1e-4 * scale)


def test_kl_is_that_of_torchs_distributions() -> None:
    mean, log_variance = torch.randn(2, 7, 32, generator=seeded(4))
    posterior, prior = Normal(mean, (0.5 * log_variance).exp()), Normal(0.0, 1.0)
    torch.testing.assert_close(kl_nats(mean, log_variance), kl_divergence(posterior, prior).sum(1))


def test_weights_come_back(both: tuple[Vae, PublishedVae], tmp_path: Path) -> None:
    checkpoints.save(tmp_path / "vae.pt", both[0].state_dict())
    pictures = torch.rand(2, 3, 64, 64, generator=seeded(2))
    with torch.inference_mode():
        assert torch.equal(load_vae(tmp_path / "vae.pt").encode(pictures)[0], both[0].encode(pictures)[0])


def test_foreign_weights_are_refused(tmp_path: Path) -> None:
    checkpoints.save(tmp_path / "vae.pt", {"weight": torch.ones(3)})
    with pytest.raises(BelvedereError, match="holds no weights of a VAE"):
        load_vae(tmp_path / "vae.pt")
