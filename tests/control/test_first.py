"""The first controller: checked against NumPy's least squares and on a task whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from pipeline.control.first import Experience, from_rewards
from pipeline.control.policy import FEATURES, Controllers
from pipeline.worldmodel.mdnrnn import MdnRnn

EPISODES, FRAMES, ACTIONS = 300, 20, 2
STEP_M, RIDGE = 0.02, 1e-3


@pytest.fixture(scope="module")
def rnn() -> MdnRnn:
    torch.manual_seed(1)
    return MdnRnn(ACTIONS, log_sigma_bound=5.0).eval().requires_grad_(False)


@pytest.fixture(scope="module")
def experience() -> Experience:
    """A point pushed about at random; the first two latents say where it is, the next two the target."""
    rng = np.random.default_rng(1)
    action = rng.uniform(-1, 1, (EPISODES, FRAMES, ACTIONS)).astype(np.float32)
    target = rng.uniform(-0.2, 0.2, (EPISODES, 1, ACTIONS))
    tip = rng.uniform(-0.2, 0.2, (EPISODES, 1, ACTIONS)) + STEP_M * np.cumsum(action, axis=1)
    before = tip - STEP_M * action
    mean = rng.normal(size=(EPISODES, FRAMES, 32)).astype(np.float32) * 0.1
    mean[..., :2], mean[..., 2:4] = 5 * before, 5 * target
    reward = -np.linalg.norm(tip - target, axis=-1).astype(np.float32)
    return Experience.of(mean, action, reward)


def test_it_points_to_the_target(rnn: MdnRnn, experience: Experience) -> None:
    controller = Controllers.of(from_rewards(rnn, experience, RIDGE)[None], ACTIONS, each=EPISODES)
    latents = experience.latents[:, 0]
    actions = controller(latents, torch.zeros(EPISODES, 256)).numpy()
    way = (latents[:, 2:4] - latents[:, :2]).numpy()
    cosines = (actions * way).sum(1) / np.linalg.norm(actions, axis=1) / np.linalg.norm(way, axis=1)
    assert np.median(cosines) > 0.95


def test_it_is_the_least_squares_solution_scaled(rnn: MdnRnn, experience: Experience) -> None:
    state, features = rnn.initial_state(EPISODES), []
    for t in range(FRAMES):
        features.append(torch.cat([experience.latents[:, t], state.h, torch.ones(EPISODES, 1)], dim=1))
        state = rnn.step(experience.latents[:, t], experience.action[:, t], state)
    known = np.stack([f.double().numpy() for f in features], axis=1)[:, 1:].reshape(-1, FEATURES + 1)
    pushed = experience.action[:, 1:].double().reshape(-1, ACTIONS).numpy()
    columns = np.concatenate([known * pushed[:, :1], known * pushed[:, 1:], known], axis=1)
    changes = experience.reward.double().diff(dim=1).reshape(-1).numpy()
    penalty = np.sqrt(RIDGE * (columns**2).sum(0))
    system = np.concatenate([columns, np.diag(penalty)])
    solution = np.linalg.lstsq(system, np.concatenate([changes, np.zeros(len(penalty))]), rcond=None)[0]
    expected = solution[: ACTIONS * (FEATURES + 1)].reshape(ACTIONS, FEATURES + 1)
    expected /= np.sqrt(((known @ expected.T) ** 2).mean())
    np.testing.assert_allclose(
        from_rewards(rnn, experience, RIDGE), expected.reshape(-1), rtol=1e-6, atol=1e-9
    )


def test_without_any_change_of_reward_it_does_nothing(rnn: MdnRnn, experience: Experience) -> None:
    """As where no random episode touched what is to be pushed."""
    same = Experience(experience.latents, experience.action, torch.full_like(experience.reward, -0.1))
    assert not from_rewards(rnn, same, RIDGE).any()
