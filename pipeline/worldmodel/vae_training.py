"""How the VAE of one repeat is trained and tested."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from pipeline.learning.device import Compute
from pipeline.learning.training import Problem, seeded, train
from pipeline.worldmodel import pictures
from pipeline.worldmodel.params import VaeParams, VaeSizes
from pipeline.worldmodel.vae import LATENTS, Vae, kl_nats

ACTIVE_VARIANCE = 0.01  # a latent whose posterior mean varies less than this carries nothing
JUDGING_BATCH = 256
# Variance of a layer's output over its input's; 2 where a ReLU follows, which halves it.
GAINS = {"mean": 1.0, "log_variance": 0.1, "decoder_input": 1.0, "deconv4": 1.0}


@dataclass(frozen=True)
class Losses:
    """Per picture, each (n,).

    Attributes:
        reconstruction: squared error summed over pixels and colours, colours in [0, 1].
        kl: nats.
    """

    reconstruction: Tensor
    kl: Tensor

    def total(self, params: VaeParams) -> Tensor:
        """The loss (n,): squared error + beta · max(KL, tolerance), as Ha and Schmidhuber (2018)."""
        return self.reconstruction + params.beta * self.kl.clamp(min=params.kl_tolerance_nats)


def losses(vae: Vae, folded_bytes: Tensor, noise: Tensor, compute: Compute) -> Losses:
    """The losses of pictures (n, 32, 32, 12) bytes, with z = mean + sigma · noise (n, 32)."""
    inputs = pictures.floats(folded_bytes)
    with compute.autocast():
        mean, log_variance = vae.encode_folded(inputs)
        outputs = vae.decode_blocks(mean + (0.5 * log_variance).exp() * noise)
    error = (outputs - pictures.blocks(inputs)).square().flatten(1).sum(1)
    return Losses(error, kl_nats(mean, log_variance))


def fit(
    training: np.ndarray,
    heldout: np.ndarray,
    params: VaeParams,
    sizes: VaeSizes,
    compute: Compute,
    seed: int,
    running: Path,
    what: str,
) -> tuple[Vae, dict[str, float]]:
    """Trains a VAE.

    Args:
        training: bytes (n, 64, 64, 3).
        heldout: the same, of other episodes; they choose the weights.
        params: loss, learning rate and plateau rule.
        sizes: epochs and batch.
        compute: where.
        seed: of first weights, order and noise.
        running: folder of the running checkpoint.
        what: the progress bar's words.

    Returns:
        The network, and its numbers for the metrics.
    """
    generator = seeded(seed)
    vae = initialised(generator).to(compute.device)
    seen, unseen = pictures.fold(training).to(compute.device), pictures.fold(heldout).to(compute.device)
    fixed_noise = torch.randn(len(unseen), LATENTS, generator=generator)

    def loss(indices: Tensor, draws: torch.Generator) -> Tensor:
        noise = torch.randn(len(indices), LATENTS, generator=draws).to(compute.device)
        return losses(vae, seen[indices.to(compute.device)], noise, compute).total(params).mean()

    def heldout_loss() -> float:
        return float(heldout_losses(vae, unseen, fixed_noise, compute).total(params).mean())

    problem = Problem("vae", vae, len(seen), sizes.batch, sizes.epochs, loss, heldout_loss)
    plateau = train(problem, params.schedule, generator, running, what)
    with torch.inference_mode():
        final = heldout_losses(vae, unseen, fixed_noise, compute)
        mean = torch.cat([vae.encode_folded(pictures.floats(b))[0] for b in unseen.split(JUDGING_BATCH)])
    return vae, {
        "epochs": plateau.epoch,
        "training_loss": plateau.training_loss,
        "heldout_loss": plateau.best_loss,
        "reconstruction_error": float(final.reconstruction.mean()),
        "kl_nats": float(final.kl.mean()),
        "active_dimensions": int((mean.var(0) > ACTIVE_VARIANCE).sum()),
    }


def heldout_losses(vae: Vae, folded_bytes: Tensor, noise: Tensor, compute: Compute) -> Losses:
    """The losses of many pictures, a batch at a time."""
    parts = list(zip(folded_bytes.split(JUDGING_BATCH), noise.split(JUDGING_BATCH), strict=True))
    each = [losses(vae, part, draws.to(compute.device), compute) for part, draws in parts]
    return Losses(torch.cat([e.reconstruction for e in each]), torch.cat([e.kl for e in each]))


def initialised(generator: torch.Generator) -> Vae:
    """A VAE whose first weights come from ``generator`` alone.

    Each layer keeps its input's variance (He et al. 2015): of a transposed convolution only the taps that
    meet in one place count. With Glorot's rule, which counts all, pictures hardly depend on z at first.
    """
    vae = Vae()
    with torch.no_grad():
        for name, layer in vae.named_children():
            weight, bias = layer.get_parameter("weight"), layer.get_parameter("bias")
            bound = math.sqrt(3 * GAINS.get(name, 2.0) / _inputs(name, weight))
            weight.copy_((torch.rand(weight.shape, generator=generator) * 2 - 1) * bound)
            bias.zero_()
    return vae


def _inputs(name: str, weight: Tensor) -> float:
    """How many numbers each output of a layer is a sum of."""
    if not name.startswith("deconv"):
        return weight[0].numel()
    one_place = name == "deconv1"  # its input is a single place, so no taps meet
    return weight.shape[0] * (1 if one_place else weight[0, 0].numel() / 4)
