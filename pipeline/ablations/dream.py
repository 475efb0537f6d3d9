"""Closed loops without the simulator: the MDN-RNN's expectations take its place (Ha and Schmidhuber 2018).

The dream begins at the latents with which random episodes begin. After each action the next latents are
drawn from the mixture that the MDN-RNN expects, and a small network reads the reward from them.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor, nn

from pipeline.ablations.params import RewardParams
from pipeline.control.jobs import Job
from pipeline.control.loop import Trace
from pipeline.control.policy import Controllers
from pipeline.learning.training import seeded
from pipeline.sim.draws import Episodes
from pipeline.sim.scene import Scene
from pipeline.worldmodel.mdnrnn import GAUSSIANS, MdnRnn, Mixture
from pipeline.worldmodel.vae import LATENTS


@dataclass(frozen=True, eq=False)
class Dream:
    """What one world model dreams.

    Attributes:
        rnn: what is expected after each action.
        reward: latents (n, 32) to rewards (n, 1), m.
        first: (e, 32) latents with which episodes begin.
        temperature: of the mixtures.
    """

    rnn: MdnRnn
    reward: nn.Module
    first: Tensor
    temperature: float

    @torch.inference_mode()
    def play(self, controllers: Controllers, begins: Tensor, draws: torch.Generator, frames: int) -> Tensor:
        """Rewards (n, frames) of controllers, each in the episode whose number ``begins`` (n,) says.

        Controllers in the same episode meet the same luck: the same first latents, the same quantiles.
        """
        episodes = int(begins.max()) + 1
        latents = self.first[torch.randint(len(self.first), (episodes,), generator=draws)][begins]
        state, rewards = self.rnn.initial_state(len(begins)), []
        for _ in range(frames):
            state = self.rnn.step(latents, controllers(latents, state.h), state)
            which = torch.rand(episodes, LATENTS, generator=draws)[begins]
            noise = torch.randn(episodes, LATENTS, generator=draws)[begins]
            latents = drawn(self.rnn, state.h, self.temperature, which, noise)
            rewards.append(self.reward(latents)[:, 0])
        return torch.stack(rewards, dim=1)


def drawn(rnn: MdnRnn, hidden: Tensor, temperature: float, which: Tensor, noise: Tensor) -> Tensor:
    """Latents (n, 32) from the mixtures expected at h (n, 256).

    Args:
        rnn: whose mixtures.
        hidden: after the action.
        temperature: divides the log weights and multiplies the variances.
        which: uniform in [0, 1): says which Gaussian, (n, 32).
        noise: standard normal, (n, 32).
    """
    mixture = expected(rnn, hidden)
    shares = (mixture.log_weight / temperature).softmax(-1).cumsum(-1)
    chosen = (which[..., None] >= shares[..., :-1]).sum(-1, keepdim=True)
    mean, log_sigma = (each.gather(-1, chosen)[..., 0] for each in (mixture.mean, mixture.log_sigma))
    return mean + log_sigma.exp() * temperature**0.5 * noise


def expected(rnn: MdnRnn, hidden: Tensor) -> Mixture:
    """What the network's own forward pass expects where its LSTM's output is h (n, 256)."""
    raw = rnn.mixture(hidden).float().unflatten(-1, (3, LATENTS, GAUSSIANS))
    weight, mean, log_sigma = raw.unbind(-3)
    bound = rnn.log_sigma_bound
    return Mixture(weight.log_softmax(-1), mean, bound * torch.tanh(log_sigma / bound))


class DreamLoops:
    """Loops (:class:`pipeline.control.loops.Loops`) in which dreams take the simulator's place.

    Args:
        scene: says how long an episode is; its episodes' draws seed those of the dream.
        dreams: those that jobs name.
    """

    def __init__(self, scene: Scene, dreams: Sequence[Dream]) -> None:
        self.scene, self._dreams = scene, dreams

    def run(self, jobs: Sequence[Job]) -> Iterator[Trace]:
        """Each job's rewards; of all else that a trace holds a dream has nothing."""
        for job in jobs:
            begins, seed = _numbered(job.episodes)
            rewards = self._dreams[job.member].play(job.controllers, begins, seeded(seed), self.scene.frames)
            none = np.empty((len(begins), 0))
            yield Trace(none, none, none, rewards.double().numpy(), none)


def _numbered(episodes: Episodes) -> tuple[Tensor, int]:
    """Which of the distinct episodes each one is, (n,), and a seed that follows from them."""
    rows = np.concatenate([episodes.start_m, episodes.target_m, episodes.drawn], axis=1)
    distinct, which = np.unique(rows, axis=0, return_inverse=True)
    return torch.from_numpy(which.reshape(-1)), zlib.crc32(distinct.tobytes())


def learn_reward(
    mean: Tensor, log_variance: Tensor, reward: Tensor, declared: RewardParams, seed: int
) -> nn.Module:
    """A network that reads the reward from the latents of the picture after it.

    Args:
        mean: of the posteriors, (e, t, 32).
        log_variance: of the posteriors, likewise; the network sees draws, as a dream gives them.
        reward: (e, t), m, after each picture's action.
        declared: its size and training.
        seed: of weights and draws.
    """
    generator = seeded(seed)
    mean, sigma = mean[:, 1:].flatten(0, 1), (0.5 * log_variance[:, 1:].flatten(0, 1)).exp()
    wanted = reward[:, :-1].flatten().float()[:, None]
    middle, spread = wanted.mean(), wanted.std().clamp(min=1e-6)
    width = declared.hidden_units
    inner = nn.Sequential(nn.Linear(LATENTS, width), nn.Tanh(), nn.Linear(width, width), nn.Tanh())
    network = nn.Sequential(inner, nn.Linear(width, 1))
    for layer in network.modules():
        if isinstance(layer, nn.Linear):
            nn.init.xavier_uniform_(layer.weight, generator=generator)
            nn.init.zeros_(layer.bias)
    optimizer = torch.optim.Adam(network.parameters(), lr=declared.learning_rate, fused=True)
    decay = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, declared.steps)
    for _ in range(declared.steps):
        rows = torch.randint(len(wanted), (min(declared.batch, len(wanted)),), generator=generator)
        noise = torch.randn(len(rows), LATENTS, generator=generator)
        error = network(mean[rows] + sigma[rows] * noise) - (wanted[rows] - middle) / spread
        optimizer.zero_grad()
        error.square().mean().backward()
        optimizer.step()
        decay.step()
    last = network[1]
    assert isinstance(last, nn.Linear)
    with torch.no_grad():  # in metres again
        last.weight.mul_(spread)
        last.bias.mul_(spread).add_(middle)
    return network.eval().requires_grad_(False)
