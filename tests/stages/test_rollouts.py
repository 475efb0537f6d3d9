"""The rollouts: reproducible, on a grid, and states from which the recorded places follow."""

from __future__ import annotations

import mujoco
import numpy as np

from pipeline.contract import params
from pipeline.contract.progress import Progress
from pipeline.sim.exploration import roll
from pipeline.sim.params import ExplorationParams
from pipeline.sim.scene import load_scene

GRID = 2.0**-20


def rolled(name: str) -> dict[str, np.ndarray]:
    process = params.section(ExplorationParams, "rollouts")
    with Progress(50, "rollouts") as progress:
        return roll(load_scene(name), 3, process, np.random.default_rng(5), progress)


def test_the_same_generator_gives_the_same_episodes() -> None:
    first, again = rolled("panda_1dof"), rolled("panda_1dof")
    assert all(np.array_equal(first[name], again[name]) for name in first)


def test_numbers_lie_on_the_grid_and_are_not_all_nought() -> None:
    found = rolled("panda_2dof")
    for name in ("qpos", "tip", "reward"):
        steps = found[name].astype(np.float64) / GRID
        assert np.array_equal(steps, np.round(steps))
        assert np.abs(found[name]).max() > 0.1


def test_the_tip_is_where_the_stored_posture_puts_it() -> None:
    scene, found = load_scene("panda_2dof"), rolled("panda_2dof")
    data = mujoco.MjData(scene.model)
    for episode, frame in ((0, 0), (1, 20), (2, 49)):
        data.qpos[:] = found["qpos"][episode, frame]
        mujoco.mj_kinematics(scene.model, data)
        np.testing.assert_allclose(data.site_xpos[scene.tip_site], found["tip"][episode, frame], atol=1e-5)
        away = np.linalg.norm(found["tip"][episode, frame] - found["target"][episode])
        if frame > 0:  # the reward belongs to the place after the action before
            assert abs(away + found["reward"][episode, frame - 1]) < 1e-5
