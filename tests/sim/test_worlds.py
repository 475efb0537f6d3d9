"""The batch of worlds: against the single dm_control world, MuJoCo's laws, and Fetch's published returns."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import Renderer
from pipeline.sim.arm_controllers import next_setpoint
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.environment import environment
from pipeline.sim.scene import Scene
from pipeline.sim.wheel_robots import UPRIGHT
from pipeline.sim.worlds import Worlds
from tests.sim.conftest import VIEWS, compile_changed, compiled

COUNT = 3


def run(worlds: Worlds, episodes: Episodes, actions: np.ndarray) -> dict[str, np.ndarray]:
    """Rewards, tips and positions of given actions (world, frame, axis)."""
    worlds.reset(episodes)
    rewards, tips, qpos = [], [worlds.tip], [worlds.qpos]
    for t in range(actions.shape[1]):
        rewards.append(worlds.step(actions[:, t]))
        tips.append(worlds.tip)
        qpos.append(worlds.qpos)
    return {"reward": np.stack(rewards, 1), "tip": np.stack(tips, 1), "qpos": np.stack(qpos, 1)}


def drawn(scene: Scene, seed: int, count: int = COUNT) -> tuple[Episodes, np.ndarray]:
    rng = np.random.default_rng(seed)
    return draw_episodes(scene, count, rng), rng.uniform(-1, 1, (count, scene.frames, scene.action_size))


def test_batch_and_dm_control_agree_to_the_bit(scene: Scene) -> None:
    episodes, actions = drawn(scene, 0)
    batch = run(Worlds(scene, COUNT), episodes, actions)
    env = environment(scene, np.random.default_rng(0))
    view = next(view for view in VIEWS if view.scene == scene.name)
    images = Renderer(scene, view, 2)
    for world in range(COUNT):
        env.task.start_with(episodes[np.array([world])])
        step = env.reset()
        for t in range(scene.frames):
            step = env.step(actions[world, t])
            assert step.reward == batch["reward"][world, t]
            np.testing.assert_array_equal(step.observation["tip_m"], batch["tip"][world, t + 1])
        assert step.last()
        assert step.discount == 1.0  # a time limit, not an end
        qpos = np.stack([env.physics.data.qpos.astype(np.float32), batch["qpos"][world, -1]])
        first, second = images.render(qpos, np.repeat(episodes.target_m[[world]], 2, axis=0))
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(
    ("frames", "substeps", "timestep_s"), [(3, 5, 0.005), (7, 20, 0.002), (50, 20, 0.002)]
)
def test_dm_controls_episode_has_the_scenes_frames(frames: int, substeps: int, timestep_s: float) -> None:
    """3 · (5 · 0.005) is more than 3 · 5 · 0.005 in floats."""
    own = compiled("panda_2dof").params
    sizes = {"frames": frames, "substeps": substeps, "timestep_s": timestep_s}
    env = environment(compile_changed("other", own.model_copy(update=sizes)), np.random.default_rng(0))
    env.reset()
    still = np.zeros(2)
    assert [env.step(still).last() for _ in range(frames)] == [False] * (frames - 1) + [True]


def test_thread_count_and_batch_size_change_no_bit(scene: Scene) -> None:
    episodes, actions = drawn(scene, 1, 5)
    one, two = run(Worlds(scene, 5, 1), episodes, actions), run(Worlds(scene, 5, 2), episodes, actions)
    alone = run(Worlds(scene, 1), episodes[np.array([4])], actions[4:])
    for name in one:
        np.testing.assert_array_equal(one[name], two[name])
        np.testing.assert_array_equal(one[name][4:], alone[name])


def test_reward_is_minus_the_distance(scene: Scene) -> None:
    episodes, actions = drawn(scene, 2)
    result = run(Worlds(scene, COUNT), episodes, actions)
    distance = np.sqrt(((result["tip"][:, 1:] - episodes.target_m[:, None]) ** 2).sum(-1))
    np.testing.assert_allclose(result["reward"], -distance, rtol=1e-12)


def test_joint_limits_and_workspace_hold_under_full_pushes(scene: Scene) -> None:
    episodes, _ = drawn(scene, 3)
    model, axes = scene.model, list(scene.axes)
    for sign in (-1.0, 1.0):
        push = np.full((COUNT, scene.frames, scene.action_size), sign)
        result = run(Worlds(scene, COUNT), episodes, push)
        for joint in np.flatnonzero(model.jnt_limited):
            q = result["qpos"][..., model.jnt_qposadr[joint]]
            low, high = model.jnt_range[joint]
            low = min(low, q[:, 0].min())  # Fetch's torso rests below its range in FetchReach, too
            assert q.min() > low - 0.02
            assert q.max() < high + 0.02
        margin = 0.03  # the hand swings past the edge a little before it stops
        low = np.array(scene.params.workspace.low_m)[axes] - margin
        high = np.array(scene.params.workspace.high_m)[axes] + margin
        tip = result["tip"][..., axes]
        assert (tip > low).all()
        assert (tip < high).all()


def test_a_full_push_moves_the_tip_about_as_far_as_fetch_does(scene: Scene) -> None:
    """A commanded 0.05 m moves Fetch about 0.033 m a frame; the Panda is tuned to the same order."""
    episodes, _ = drawn(scene, 4)
    middle = np.mean([scene.params.workspace.low_m, scene.params.workspace.high_m], axis=0)
    setpoint = np.sign(middle - episodes.start_m)
    push = np.repeat(np.where(setpoint == 0, 1, setpoint)[:, None, list(scene.axes)], 3, axis=1)
    tip = run(Worlds(scene, COUNT), episodes, push)["tip"][..., list(scene.axes)]
    step = np.abs(np.diff(tip, axis=1))[:, -1].max()
    assert 0.015 < step < 0.045


def test_standing_still_stands_still(scene: Scene) -> None:
    episodes, actions = drawn(scene, 5)
    tip = run(Worlds(scene, COUNT), episodes, 0 * actions)["tip"]
    assert np.abs(tip - episodes.start_m[:, None]).max() < 0.01  # gravity is on


def test_gravity_is_on(scene: Scene) -> None:
    assert scene.model.opt.gravity[2] == pytest.approx(-9.81)
    assert not scene.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT


def test_the_obstacle_cannot_be_passed_through() -> None:
    scene = compiled("panda_2dof_obstacle")
    box = scene.params.obstacles[0]
    side = box.half_size_m[1] + 0.08
    start = np.array([[box.center_m[0], -side, 0.09]])
    episodes = Episodes.at(start, start * [1, -1, 1])
    push = np.zeros((1, scene.frames, 2))
    push[..., 0] = 1.0
    tip = run(Worlds(scene, 1), episodes, push)["tip"][0]
    assert tip[:, 1].max() < box.center_m[1]
    free = compiled("panda_2dof")
    passed = run(Worlds(free, 1), episodes, push)["tip"][0]
    assert passed[:, 1].max() > side - 0.02  # without it the same push arrives


def test_fetch_returns_are_those_of_fetch_reach() -> None:
    """Reference over 20 seeds on current MuJoCo: nothing -7.23, uniform -10.98, proportional -0.27."""
    scene = compiled("fetch_reach")
    far = scene.params.workspace.model_copy(update={"low_m": (-9.0, -9.0, -9.0), "high_m": (9.0, 9.0, 9.0)})
    cube = scene.params.target.model_copy(update={"jitter_m": (0.15, 0.15, 0.15)})
    gym = compile_changed("gym", scene.params.model_copy(update={"workspace": far, "target": cube}))
    count = 200
    rng = np.random.default_rng(0)
    episodes, worlds = draw_episodes(gym, count, rng), Worlds(gym, count, 2)
    nothing = run(worlds, episodes, np.zeros((count, 50, 3)))["reward"].sum(1).mean()
    uniform = run(worlds, episodes, rng.uniform(-1, 1, (count, 50, 3)))["reward"].sum(1).mean()
    worlds.reset(episodes)
    feedback = np.zeros(count)
    for _ in range(50):
        feedback += worlds.step((worlds.target - worlds.tip) / gym.params.displacement_m)
    assert nothing == pytest.approx(-7.23, abs=0.5)
    assert uniform == pytest.approx(-10.98, abs=1.5)  # 20 episodes' mean is 0.7 uncertain
    assert feedback.mean() == pytest.approx(-0.27, abs=0.1)


def test_fetchs_gripper_keeps_pointing_down() -> None:
    """FetchReach's rotation control: 1.1° in the median (at most 7°) after random episodes there."""
    scene = compiled("fetch_reach")
    episodes, actions = drawn(scene, 8)
    qpos = run(Worlds(scene, COUNT), episodes, actions)["qpos"][:, -1]
    data, down = mujoco.MjData(scene.model), np.array(UPRIGHT) / np.linalg.norm(UPRIGHT)
    tilt_deg = []
    for data.qpos[:] in qpos:
        mujoco.mj_kinematics(scene.model, data)
        upright = abs(data.xquat[scene.model.site_bodyid[scene.tip_site]] @ down)
        tilt_deg.append(np.degrees(2 * np.arccos(min(upright, 1.0))))
    assert np.median(tilt_deg) < 5


def test_initial_grip_is_fetchs(scene: Scene) -> None:
    if scene.robot.control == "weld":
        worlds = Worlds(scene, 1)
        worlds.reset(draw_episodes(scene, 1, np.random.default_rng(0)))
        np.testing.assert_allclose(worlds.tip[0], [1.3418, 0.7491, 0.5347], atol=1e-3)


def test_inverse_kinematics_follow_the_jacobian(scene: Scene) -> None:
    """A small setpoint displacement is reached along itself, on the controlled axes."""
    episodes, _ = drawn(scene, 6)
    action = np.full((COUNT, scene.action_size), 0.2)
    setpoint = next_setpoint(scene, episodes.start_m, episodes.start_m, action)
    assert np.allclose((setpoint - episodes.start_m)[:, list(scene.axes)], 0.2 * scene.params.displacement_m)
    others = [axis for axis in range(3) if axis not in scene.axes]
    assert (setpoint - episodes.start_m)[:, others].any() is np.False_ or not others


def test_out_of_reach_and_not_a_number_are_told() -> None:
    scene = compiled("panda_2dof")
    far = np.array([[2.0, 0.0, 0.2]])
    with pytest.raises(BelvedereError, match=r"cannot bring its tip to \[2.0, 0.0, 0.2\] m"):
        Worlds(scene, 1).reset(Episodes.at(far, far))
    episodes, _ = drawn(scene, 7, 1)
    worlds = Worlds(scene, 1)
    worlds.reset(episodes)
    with pytest.raises(BelvedereError, match="not a number"):
        worlds.step(np.array([[np.nan, 0.0]]))


def test_pictures_of_two_views_differ(view: Viewpoint) -> None:
    scene = compiled(view.scene)
    worlds = Worlds(scene, 1)
    worlds.reset(draw_episodes(scene, 1, np.random.default_rng(0)))
    here = Renderer(scene, view, 1).render(worlds.qpos, worlds.target).astype(int)
    turned = Viewpoint(scene=view.scene, theta=view.theta + 20, phi=view.phi)
    there = Renderer(scene, turned, 1).render(worlds.qpos, worlds.target).astype(int)
    assert np.abs(here - there).mean() > 1
