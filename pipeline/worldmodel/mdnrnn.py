"""The MDN-RNN of Ha and Schmidhuber (2018): an LSTM that expects the next latents.

Per latent dimension its output is a mixture of five Gaussians. There are no reward and end heads:
the reward is known here and episodes never end early.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import Tensor, nn

from pipeline.contract.errors import BelvedereError
from pipeline.learning import checkpoints
from pipeline.worldmodel.vae import LATENTS

UNITS = 256
GAUSSIANS = 5


@dataclass(frozen=True)
class Mixture:
    """Mixtures of Gaussians, one per latent dimension; each tensor (…, 32, 5).

    Attributes:
        log_weight: log of the mixture weights, normalised over the last axis.
        mean: of each Gaussian.
        log_sigma: log standard deviation.
    """

    log_weight: Tensor
    mean: Tensor
    log_sigma: Tensor

    def nll(self, latents: Tensor) -> Tensor:
        """Negative log likelihood, nats, of each latent dimension: (…, 32)."""
        distance = (latents[..., None] - self.mean) * (-self.log_sigma).exp()
        log_density = -0.5 * distance.square() - self.log_sigma - 0.5 * math.log(2 * math.pi)
        return -torch.logsumexp(self.log_weight + log_density, dim=-1)


@dataclass(frozen=True)
class State:
    """The LSTM's state of n worlds: hidden ``h`` and cell ``c``, each (n, 256)."""

    h: Tensor
    c: Tensor


class MdnRnn(nn.Module):
    """The network; 423,392 parameters at 3 actions.

    Args:
        actions: action dimensions.
        log_sigma_bound: log standard deviations stay within ± this (smoothly).
    """

    def __init__(self, actions: int, log_sigma_bound: float) -> None:
        super().__init__()
        self.actions, self.log_sigma_bound = actions, log_sigma_bound
        self.lstm = nn.LSTM(LATENTS + actions, UNITS, batch_first=True)
        self.mixture = nn.Linear(UNITS, 3 * LATENTS * GAUSSIANS)

    def forward(self, latents: Tensor, actions: Tensor) -> Mixture:
        """What is expected after each step of latents (b, t, 32) and actions (b, t, a), from rest."""
        hidden, _ = self.lstm(torch.cat([latents, actions], dim=-1))
        raw = self.mixture(hidden).float().unflatten(-1, (3, LATENTS, GAUSSIANS))
        weight, mean, log_sigma = raw.unbind(-3)
        bound = self.log_sigma_bound
        return Mixture(weight.log_softmax(-1), mean, bound * torch.tanh(log_sigma / bound))

    def initial_state(self, count: int) -> State:
        """The state at rest of ``count`` worlds."""
        zeros = torch.zeros(count, UNITS, device=self.mixture.weight.device)
        return State(zeros, zeros)

    @torch.inference_mode()
    def step(self, latents: Tensor, actions: Tensor, state: State) -> State:
        """The state after latents (n, 32) and actions (n, a): the LSTM's cell alone."""
        h, c = torch.ops.aten.lstm_cell(
            torch.cat([latents, actions], dim=-1),
            (state.h, state.c),
            self.lstm.weight_ih_l0,
            self.lstm.weight_hh_l0,
            self.lstm.bias_ih_l0,
            self.lstm.bias_hh_l0,
        )
        return State(h, c)


def save_mdnrnn(path: Path, network: MdnRnn) -> None:
    """Writes what :func:`load_mdnrnn` reads."""
    shape = {"actions": network.actions, "log_sigma_bound": network.log_sigma_bound}
    checkpoints.save(path, {**shape, "weights": network.cpu().state_dict()})


def load_mdnrnn(path: Path) -> MdnRnn:
    """The network that ``pipeline.mdnrnn`` wrote to ``path``.

    Raises:
        BelvedereError: the file is missing, truncated or foreign.
    """
    content = checkpoints.load(path, "mdnrnn")
    try:
        network = MdnRnn(content["actions"], content["log_sigma_bound"])
        network.load_state_dict(content["weights"])
    except (KeyError, TypeError, RuntimeError):
        raise BelvedereError(
            f"{path} holds no weights of an MDN-RNN; delete it and run `dvc repro mdnrnn`."
        ) from None
    return network.eval().requires_grad_(False)
