"""The dream against the network's own forward pass, the distribution of its draws, and its rewards."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy import stats
from torch import nn

from pipeline.ablations.dream import Dream, DreamLoops, drawn, expected, learn_reward
from pipeline.ablations.params import RewardParams
from pipeline.control.jobs import Job
from pipeline.control.policy import parameters
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.worldmodel.mdnrnn import GAUSSIANS, MdnRnn
from pipeline.worldmodel.vae import LATENTS

REWARD = RewardParams(hidden_units=32, learning_rate=0.01, batch=128, steps=400)
ACTIONS = 2


@pytest.fixture
def rnn() -> MdnRnn:
    torch.manual_seed(3)
    return MdnRnn(ACTIONS, log_sigma_bound=5.0).eval().requires_grad_(False)


def first_of(latents: torch.Tensor) -> nn.Module:
    """A reward that is the first latent."""
    layer = nn.Linear(LATENTS, 1)
    nn.init.zeros_(layer.weight), nn.init.zeros_(layer.bias)
    layer.weight.data[0, 0] = 1.0
    return layer.requires_grad_(False)


def test_what_is_expected_is_the_network_s_own_forward_pass(rnn: MdnRnn) -> None:
    latents, actions = torch.randn(5, 7, LATENTS), torch.randn(5, 7, ACTIONS)
    whole, state = rnn(latents, actions), rnn.initial_state(5)
    for t in range(7):
        state = rnn.step(latents[:, t], actions[:, t], state)
        found = expected(rnn, state.h)
        for name in ("log_weight", "mean", "log_sigma"):
            torch.testing.assert_close(getattr(found, name), getattr(whole, name)[:, t], atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize("temperature", [0.5, 1.0, 1.7])
def test_draws_have_the_mixture_s_distribution(rnn: MdnRnn, temperature: float) -> None:
    generator, count = torch.Generator().manual_seed(1), 20_000
    with torch.no_grad():
        rnn.mixture.bias.uniform_(-1.5, 1.5, generator=generator)
    hidden = torch.zeros(1, 256)
    which = torch.rand(count, LATENTS, generator=generator)
    noise = torch.randn(count, LATENTS, generator=generator)
    found = drawn(rnn, hidden.expand(count, -1), temperature, which, noise).numpy()
    mixture = expected(rnn, hidden)
    weights = (mixture.log_weight[0] / temperature).softmax(-1).numpy()
    means, sigmas = mixture.mean[0].numpy(), mixture.log_sigma[0].exp().numpy() * temperature**0.5
    assert weights.shape == (LATENTS, GAUSSIANS)
    for latent in (0, 17):

        def cdf(x: np.ndarray, own: int = latent) -> np.ndarray:
            parts = stats.norm.cdf(np.atleast_1d(x)[:, None], means[own], sigmas[own])
            return np.asarray((parts * weights[own]).sum(axis=1))

        assert stats.kstest(found[:, latent], cdf).pvalue > 1e-3


def test_candidates_of_a_generation_meet_the_same_luck(rnn: MdnRnn) -> None:
    scene = load_scene("panda_2dof")
    loops = DreamLoops(scene, [Dream(rnn, first_of(torch.empty(0)), torch.randn(9, LATENTS), 1.0)])
    episodes = draw_episodes(scene, 3, np.random.default_rng(1))
    alike = np.repeat(np.random.default_rng(2).normal(size=(1, parameters(ACTIONS))), 4, axis=0)
    (trace,) = loops.run([Job.of(0, alike, episodes)])
    returns = trace.returns.reshape(4, 3)
    assert np.ptp(returns, axis=0).max() == 0 and np.ptp(returns, axis=1).max() > 0
    (again,) = loops.run([Job.of(0, alike, episodes)])
    assert np.array_equal(again.reward, trace.reward) and trace.reward.shape == (12, scene.frames)
    (others,) = loops.run([Job.of(0, alike, draw_episodes(scene, 3, np.random.default_rng(5)))])
    assert not np.array_equal(others.reward, trace.reward)


def test_the_reward_is_read_from_the_latents_of_the_picture_after_the_action() -> None:
    generator = torch.Generator().manual_seed(2)
    mean = torch.randn(60, 20, LATENTS, generator=generator)
    quiet, reward = torch.full_like(mean, -12.0), torch.zeros(60, 20, dtype=torch.float64)
    reward[:, :-1] = 0.3 * mean[:, 1:, 0] - 2.0  # after an action stands the next picture
    unseen = torch.randn(500, LATENTS, generator=generator)
    wanted = 0.3 * unseen[:, 0] - 2.0
    network = learn_reward(mean, quiet, reward, REWARD, seed=1)
    assert (network(unseen)[:, 0] - wanted).square().mean().sqrt() < 0.4 * wanted.std()
    assert torch.equal(learn_reward(mean, quiet, reward, REWARD, seed=1)(unseen), network(unseen))
    early = learn_reward(mean, quiet, 0.3 * mean[:, :, 0].double() - 2.0, REWARD, seed=1)
    assert (early(unseen)[:, 0] - wanted).square().mean().sqrt() > 0.8 * wanted.std()
