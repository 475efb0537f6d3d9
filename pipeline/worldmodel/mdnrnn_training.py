"""How the MDN-RNN of one repeat is trained and tested."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from pipeline.learning.device import Compute
from pipeline.learning.training import Problem, seeded, train
from pipeline.worldmodel.mdnrnn import UNITS, MdnRnn
from pipeline.worldmodel.params import MdnRnnParams, MdnRnnSizes


@dataclass(frozen=True)
class Sequences:
    """Encoded episodes.

    Attributes:
        mean: (e, t, 32) posterior mean of z.
        log_variance: (e, t, 32).
        action: (e, t, a), each after the picture of its frame.
    """

    mean: Tensor
    log_variance: Tensor
    action: Tensor

    def __getitem__(self, indices: Tensor) -> Sequences:
        return Sequences(self.mean[indices], self.log_variance[indices], self.action[indices])

    def __len__(self) -> int:
        return len(self.mean)

    def sample(self, generator: torch.Generator) -> Tensor:
        """Latents (e, t, 32) drawn from their posterior."""
        noise = torch.randn(self.mean.shape, generator=generator).to(self.mean.device)
        return self.mean + (0.5 * self.log_variance).exp() * noise


def sequences(columns: Mapping[str, np.ndarray], device: torch.device) -> Sequences:
    """Encoded episodes on ``device``, of those columns of :data:`pipeline.storage.zarrs.LATENTS`."""
    return Sequences(**{name: torch.from_numpy(array).to(device) for name, array in columns.items()})


def fit(
    training: Sequences,
    heldout: Sequences,
    params: MdnRnnParams,
    sizes: MdnRnnSizes,
    compute: Compute,
    seed: int,
    running: Path,
    what: str,
) -> tuple[MdnRnn, dict[str, float]]:
    """Trains an MDN-RNN on whole episodes, each input the true (drawn) latents of its frame.

    Args:
        training: episodes to learn from.
        heldout: episodes that choose the weights.
        params: mixture, gradient clipping, learning rate and plateau rule.
        sizes: epochs and batch.
        compute: where.
        seed: of first weights, order and noise.
        running: folder of the running checkpoint.
        what: the progress bar's words.

    Returns:
        The network, and its numbers for the metrics.
    """
    generator = seeded(seed)
    network = initialised(training.action.shape[-1], params, generator).to(compute.device)
    unseen = heldout.sample(generator)

    def loss(indices: Tensor, draws: torch.Generator) -> Tensor:
        episodes = training[indices.to(compute.device)]
        return mean_nll(network, episodes.sample(draws), episodes.action, compute)

    def heldout_loss() -> float:
        return float(mean_nll(network, unseen, heldout.action, compute))

    problem = Problem(
        "mdnrnn", network, len(training), sizes.batch, sizes.epochs, loss, heldout_loss, params.gradient_norm
    )
    plateau = train(problem, params.schedule, generator, running, what)
    return network, {
        "epochs": plateau.epoch,
        "training_nll_nats_per_latent": plateau.training_loss,
        "heldout_nll_nats_per_latent": plateau.best_loss,
        "heldout_nll_of_last_frame_nats_per_latent": nll_of_last_frame(training.sample(generator), unseen),
    }


def mean_nll(network: MdnRnn, latents: Tensor, actions: Tensor, compute: Compute) -> Tensor:
    """Mean over episodes, frames and latents of the NLL (nats) of the next frame's latents."""
    with compute.autocast(recurrent=True):
        mixture = network(latents[:, :-1], actions[:, :-1])
    return mixture.nll(latents[:, 1:]).mean()


def nll_of_last_frame(training: Tensor, heldout: Tensor) -> float:
    """The NLL of a predictor that says that latents (e, t, 32) stay as they are.

    Its variance per latent is fitted on the training episodes.
    """
    variance = (training[:, 1:] - training[:, :-1]).square().mean((0, 1)).clamp(min=1e-12)
    squared = (heldout[:, 1:] - heldout[:, :-1]).square() / variance
    return float(0.5 * (squared + variance.log() + math.log(2 * math.pi)).mean())


def initialised(actions: int, params: MdnRnnParams, generator: torch.Generator) -> MdnRnn:
    """An MDN-RNN whose first weights come from ``generator`` alone; forget gates start open."""
    network = MdnRnn(actions, params.log_sigma_bound)
    with torch.no_grad():
        for name, weight in network.named_parameters():
            if weight.dim() == 2:
                bound = math.sqrt(6 / sum(weight.shape)) if name.startswith("mixture") else UNITS**-0.5
                weight.copy_((torch.rand(weight.shape, generator=generator) * 2 - 1) * bound)
            else:
                weight.zero_()
        network.get_parameter("lstm.bias_ih_l0")[UNITS : 2 * UNITS] = 1.0
    return network
