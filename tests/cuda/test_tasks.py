"""Every task on a device against MuJoCo's worlds: targets, errors, rewards, and the pictures to the byte."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.cuda.worlds import DeviceWorlds
from pipeline.rendering.renderer import Renderer
from pipeline.sim.draws import draw_episodes
from pipeline.sim.expert import Expert
from pipeline.sim.worlds import Worlds
from tests.cuda.device_cases import DEVICES
from tests.cuda.test_worlds import CUDA_LEVELS, CUDA_PIXELS
from tests.examples import KINDS, example, example_views

COUNT = 2
# Of tip and error, m; a puck that is pushed magnifies what float32 rounds in its contacts.
FREE_M, PUSHED_M = 2e-5, 5e-3


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("kind", KINDS)
def test_an_episode_under_the_expert_is_mujocos(kind: str, device: str) -> None:
    scene, view = example(kind), next(iter(example_views(kind).values()))
    episodes, expert = draw_episodes(scene, COUNT, np.random.default_rng(1)), Expert(scene)
    on_device, worlds = DeviceWorlds(scene, view, COUNT, device), Worlds(scene, COUNT)
    images = Renderer(scene, view, COUNT)
    worlds.reset(episodes)
    on_device.reset(episodes)
    tolerance_m = PUSHED_M if kind == "push" else FREE_M
    np.testing.assert_allclose(on_device.error.numpy(), worlds.error, atol=FREE_M)
    for _ in range(scene.frames):
        action = expert(worlds.state)
        reward = worlds.step(action)
        on_device.action.assign(action.astype(np.float32))
        on_device.step()
        np.testing.assert_allclose(on_device.target.numpy(), worlds.target, atol=1e-6)
        np.testing.assert_allclose(on_device.tip.numpy(), worlds.tip, atol=tolerance_m)
        np.testing.assert_allclose(on_device.reward.numpy(), reward, atol=tolerance_m)
        np.testing.assert_array_equal(on_device.error.numpy(), -on_device.reward.numpy())
        expected = images.render(on_device.qpos.numpy(), worlds.target).astype(int)
        error = np.abs(on_device.rgb.numpy() - expected).max(axis=-1)
        if device == "cpu":
            assert error.max() == 0
        else:
            assert (error > CUDA_LEVELS).mean() <= CUDA_PIXELS
    on_device.check()
    assert worlds.error.max() < 0.02  # it did the task, so the puck was pushed


@pytest.mark.parametrize("device", DEVICES)
def test_a_second_episode_begins_anew(device: str) -> None:
    """Puck and path, which an episode moves."""
    for kind in ("push", "follow"):
        scene, view = example(kind), next(iter(example_views(kind).values()))
        on_device = DeviceWorlds(scene, view, COUNT, device)
        first = draw_episodes(scene, COUNT, np.random.default_rng(2))
        seen = []
        for episodes in (first, draw_episodes(scene, COUNT, np.random.default_rng(3)), first):
            on_device.reset(episodes)
            seen.append([on_device.qpos.numpy().copy(), on_device.target.numpy().copy()])
            on_device.action.assign(np.ones((COUNT, scene.action_size), np.float32))
            for _ in range(5):
                on_device.step()
            seen[-1] += [on_device.qpos.numpy().copy(), on_device.target.numpy().copy()]
        for before, other, again in zip(*seen, strict=True):
            np.testing.assert_allclose(before, again, atol=0 if device == "cpu" else 1e-4)
            assert np.abs(before - other).max() > 1e-3, kind
