"""The arm controllers on a device against those on the CPU, without physics."""

from __future__ import annotations

import mujoco_warp as mjw
import numpy as np
import pytest
import warp as wp

from pipeline.cuda import ik
from pipeline.cuda.arm_controllers import DeviceJointController, DeviceMocapController, Setpoints
from pipeline.sim.arm_controllers import JointController, TipPose, next_setpoint
from pipeline.sim.draws import draw_episodes
from pipeline.sim.wheel_robots import UPRIGHT
from tests.cuda.device_cases import DEVICES
from tests.sim.conftest import compiled

COUNT, FRAMES = 5, 8
COMMAND_RAD = 1e-5  # poses are float32 on a device
RNG = np.random.default_rng(5)


@pytest.mark.parametrize("device", DEVICES)
def test_inverse_kinematics_command_the_same_joints_over_several_frames(device: str) -> None:
    """The tip is taken to be where it is setpoint, over and over: as far as the workspace goes."""
    scene = compiled("panda_2dof")
    episodes = draw_episodes(scene, COUNT, RNG)
    on_host = JointController(scene, COUNT, 1)
    fields = on_host.reset(episodes.start_m, episodes.target_m)
    with wp.ScopedDevice(device):
        model = mjw.put_model(scene.model)
        data = mjw.make_data(scene.model, nworld=COUNT)
        on_device = DeviceJointController(scene, model, COUNT)
        on_device.reset(fields)
        tip = episodes.start_m
        for direction in RNG.uniform(-1, 1, (FRAMES, COUNT, 2)):
            tip = next_setpoint(scene, tip, episodes.start_m, np.sign(direction))
            hand = TipPose(tip, tip, np.zeros((COUNT, 4)))
            expected = on_host.move(hand, tip)["ctrl"]
            setpoint = wp.array(tip, dtype=wp.vec3)
            on_device.move(data, setpoint, setpoint)
            np.testing.assert_allclose(data.ctrl.numpy(), expected, atol=COMMAND_RAD)


@pytest.mark.parametrize("device", DEVICES)
def test_joints_stay_within_their_ranges_out_of_reach(device: str) -> None:
    scene = compiled("panda_2dof")
    far = np.array([[3.0, 1.0, 2.0]])
    with wp.ScopedDevice(device):
        model, data = mjw.put_model(scene.model), mjw.make_data(scene.model, nworld=1)
        on_device, setpoint = DeviceJointController(scene, model, 1), wp.array(far, dtype=wp.vec3)
        on_device.reset({"qpos": data.qpos.numpy()})
        for _ in range(20):
            on_device.move(data, setpoint, setpoint)
        joints = [scene.model.joint(name) for name in scene.robot.arm]
        commanded = data.ctrl.numpy()[0, : len(joints)]
    low, high = np.array([joint.range for joint in joints]).T
    assert (commanded >= low - 1e-6).all()
    assert (commanded <= high + 1e-6).all()
    assert np.isclose(commanded, low, atol=1e-6).any() or np.isclose(commanded, high, atol=1e-6).any()


@wp.kernel
def _solve(gram: wp.array[ik._Matrix], right: wp.array[ik._Vector], found: wp.array[ik._Vector]):
    found[wp.tid()] = ik.solved(gram[wp.tid()], right[wp.tid()])


@pytest.mark.parametrize("device", DEVICES)
def test_choleskys_factors_solve_the_system(device: str) -> None:
    half = RNG.standard_normal((7, 6, 4))  # of rank 4: the damping alone makes the rest solvable
    gram, right = half @ half.transpose(0, 2, 1) + 1e-6 * np.eye(6), RNG.standard_normal((7, 6))
    with wp.ScopedDevice(device):
        found = wp.zeros(7, dtype=ik._Vector)
        arrays = wp.array(gram, dtype=ik._Matrix), wp.array(right, dtype=ik._Vector)
        wp.launch(_solve, dim=7, inputs=[*arrays], outputs=[found])
        expected = np.linalg.solve(gram, right[..., None])[..., 0]
        np.testing.assert_allclose(found.numpy(), expected, rtol=1e-7)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("name", ["panda_1dof", "panda_2dof", "fetch_reach"])
def test_setpoints_are_the_same(name: str, device: str) -> None:
    scene = compiled(name)
    episodes = draw_episodes(scene, COUNT, RNG)
    tip = episodes.start_m + RNG.normal(0, 0.2, (COUNT, 3))  # some out of the workspace
    action = RNG.uniform(-2, 2, (COUNT, scene.action_size))
    with wp.ScopedDevice(device):
        setpoints = Setpoints(scene, COUNT)
        setpoints.start.assign(episodes.start_m.astype(np.float32))
        arrays = wp.array(action, dtype=float), wp.array(tip, dtype=wp.vec3)
        found = setpoints.make(*arrays).numpy()
        assert setpoints.refused.numpy()[0] == 0
    np.testing.assert_allclose(found, next_setpoint(scene, tip, episodes.start_m, action), atol=1e-6)


@pytest.mark.parametrize("device", DEVICES)
def test_a_weld_is_pulled_from_where_the_hand_is(device: str) -> None:
    scene = compiled("fetch_reach")
    body = scene.model.site_bodyid[scene.tip_site]
    mocap = scene.model.body(scene.robot.mocap).mocapid[0]
    with wp.ScopedDevice(device):
        model, data = mjw.put_model(scene.model), mjw.make_data(scene.model, nworld=COUNT)
        mjw.kinematics(model, data)
        tip, setpoint = (wp.array(RNG.normal(size=(COUNT, 3)), dtype=wp.vec3) for _ in range(2))
        DeviceMocapController(scene, model, COUNT).move(data, tip, setpoint)
        expected = data.xpos.numpy()[:, body] + setpoint.numpy() - tip.numpy()
        np.testing.assert_allclose(data.mocap_pos.numpy()[:, mocap], expected, atol=1e-6)
        turned = data.xquat.numpy()[:, body] + np.array(UPRIGHT, np.float32)
        np.testing.assert_array_equal(data.mocap_quat.numpy()[:, mocap], turned)
