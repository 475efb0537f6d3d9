"""Arms from any file, on a device: they are driven as on the CPU, and their worlds are the CPU's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco_warp as mjw
import numpy as np
import pytest
import warp as wp

from pipeline.contract.viewpoints import Viewpoint
from pipeline.cuda.arm_controllers import DeviceJointController
from pipeline.cuda.worlds import DeviceWorlds
from pipeline.sim.arm_controllers import JointController, TipPose
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds
from tests.cuda.device_cases import DEVICES
from tests.sim import arms
from tests.sim.arms import HOME, mjcf, robot, scene

COUNT, FRAMES = 4, 8
FIVE = ("yaw", "shoulder", "elbow", "wrist", "turn")
FINGER = '<joint name="finger" type="slide" range="0 .04"/><geom size=".01"/>'
HAND = f'<body name="finger" pos="0 .05 .05">{FINGER}</body>'
GRIP = '<actuator><position name="grip" joint="finger" kp="100" kv="10"/></actuator>'
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "unlimited joints": (mjcf(joint=""), {"home": HOME}),
    "a step limit that counts": (mjcf(), {"home": HOME, "drive": {"largest_step": 0.05}}),
    "five joints": (mjcf(FIVE), {"home": {name: HOME[name] for name in FIVE}, "drive": {"keeps": "place"}}),
    "a gripper": (mjcf(hand=HAND, other=GRIP), {"home": HOME, "hold": {"grip": 0.02}}),
    "Jaco": ("", {**arms.JACO, "home": arms.JACO_HOME}),
}


@pytest.fixture(params=CASES)
def arm(request: pytest.FixtureRequest, tmp_path: Path) -> Scene:
    text, declared = CASES[request.param]
    return scene(tmp_path, robot(tmp_path, text, **declared))


@pytest.mark.parametrize("device", DEVICES)
def test_inverse_kinematics_command_the_same_joints(arm: Scene, device: str) -> None:
    rng = np.random.default_rng(5)
    episodes = draw_episodes(arm, COUNT, rng)
    on_host = JointController(arm, COUNT, 1)
    fields = {
        name: values.copy() for name, values in on_host.reset(episodes.start_m, episodes.target_m).items()
    }
    with wp.ScopedDevice(device):
        model, data = mjw.put_model(arm.model), mjw.make_data(arm.model, nworld=COUNT)
        data.ctrl.assign(fields["ctrl"].astype(np.float32))
        on_device = DeviceJointController(arm, model, COUNT)
        on_device.reset(fields)
        place = episodes.start_m
        for direction in np.sign(rng.uniform(-1, 1, (FRAMES, COUNT, 3))):
            place = np.clip(place + 0.05 * direction, (0.4, -0.15, 0.2), (0.5, 0.15, 0.5))
            expected = on_host.move(TipPose(place, place, np.zeros((COUNT, 4))), place)["ctrl"]
            setpoint = wp.array(place, dtype=wp.vec3)
            on_device.move(data, setpoint, setpoint)
            np.testing.assert_allclose(data.ctrl.numpy(), expected, atol=1e-4)


@pytest.mark.parametrize("device", DEVICES)
def test_worlds_on_a_device_are_the_cpus(arm: Scene, device: str) -> None:
    rng = np.random.default_rng(6)
    episodes = draw_episodes(arm, COUNT, rng)
    actions = rng.uniform(-1, 1, (FRAMES, COUNT, 2)).astype(np.float32)
    here, there = (
        Worlds(arm, COUNT),
        DeviceWorlds(arm, Viewpoint(scene="any", theta=0, phi=20), COUNT, device),
    )
    here.reset(episodes)
    there.reset(episodes)
    for action in actions:
        here.step(action)
        there.action.assign(action)
        there.step()
    there.check()
    np.testing.assert_allclose(there.tip.numpy(), here.tip, atol=2e-4)
    np.testing.assert_allclose(there.qpos.numpy(), here.qpos, atol=2e-3)
