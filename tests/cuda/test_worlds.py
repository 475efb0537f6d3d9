"""Worlds on a device against MuJoCo's: the same physics in float32, the same pictures to the byte."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
import warp as wp
from mujoco_warp import OverflowType

from pipeline.contract.errors import BelvedereError
from pipeline.cuda import worlds as device_worlds
from pipeline.cuda.worlds import DeviceWorlds, fields_at_start
from pipeline.rendering.renderer import Renderer
from pipeline.sim.arm_controllers import arm_controller
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.environment import environment
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds
from tests.cuda.device_cases import DEVICES
from tests.sim.conftest import SCENES, VIEWS, compiled

COUNT, SHORT = 2, 3
# mujoco_warp computes in float32. The Panda stays within a few micrometres of MuJoCo; Fetch, whose
# fingers rest on its own hand and whose weld is stiff, within a few tenths of a millimetre.
TIP_M = {"panda": 2e-5, "fetch": 1e-3}
# Another device's compiler rounds otherwise: colours by a level or two, and a ray may just miss an edge.
CUDA_LEVELS, CUDA_PIXELS = 2, 0.002


def view(scene: Scene) -> object:
    return next(view for view in VIEWS if view.scene == scene.name)


def drawn(scene: Scene, frames: int, seed: int = 1) -> tuple[Episodes, np.ndarray]:
    rng = np.random.default_rng(seed)
    actions = rng.uniform(-1, 1, (frames, COUNT, scene.action_size)).astype(np.float32)
    return draw_episodes(scene, COUNT, rng), actions


def play(worlds: DeviceWorlds, episodes: Episodes, actions: np.ndarray) -> dict[str, np.ndarray]:
    """Tips, rewards, positions and pictures after each frame."""
    worlds.reset(episodes)
    seen: dict[str, list[np.ndarray]] = {name: [] for name in ("tip", "reward", "qpos", "rgb")}
    for action in actions:
        worlds.action.assign(action)
        worlds.step()
        for name, values in seen.items():
            values.append(getattr(worlds, name).numpy().copy())
    worlds.check()
    return {name: np.stack(values) for name, values in seen.items()}


def hold_against_mujoco(name: str, device: str, actions: np.ndarray, episodes: Episodes) -> None:
    scene = compiled(name)
    on_device = play(DeviceWorlds(scene, view(scene), COUNT, device), episodes, actions)
    worlds, images = Worlds(scene, COUNT), Renderer(scene, view(scene), COUNT)
    worlds.reset(episodes)
    tolerance_m = TIP_M[scene.params.robot]
    for frame, action in enumerate(actions):
        reward = worlds.step(action.astype(np.float64))
        np.testing.assert_allclose(on_device["tip"][frame], worlds.tip, atol=tolerance_m)
        np.testing.assert_allclose(on_device["reward"][frame], reward, atol=tolerance_m)
        expected = images.render(on_device["qpos"][frame], worlds.target)
        error = np.abs(on_device["rgb"][frame].astype(int) - expected).max(axis=-1)
        if device == "cpu":
            assert error.max() == 0
        else:
            assert (error > CUDA_LEVELS).mean() <= CUDA_PIXELS


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("name", SCENES)
def test_a_whole_episode_is_mujocos(name: str, device: str) -> None:
    episodes, actions = drawn(compiled(name), compiled(name).frames)
    hold_against_mujoco(name, device, actions, episodes)


def into_the_obstacle(scene: Scene) -> tuple[Episodes, np.ndarray]:
    box = scene.params.obstacles[0]
    start = np.array([[box.center_m[0], -box.half_size_m[1] - 0.08, 0.09]] * COUNT)
    push = np.zeros((20, COUNT, 2), np.float32)
    push[..., 0] = 1.0
    return Episodes.at(start, start * [1, -1, 1]), push


@pytest.mark.parametrize("device", DEVICES)
def test_the_obstacle_stops_the_hand_as_in_mujoco(device: str) -> None:
    """What touches is where float32 could tell most."""
    scene = compiled("panda_2dof_obstacle")
    episodes, push = into_the_obstacle(scene)
    hold_against_mujoco(scene.name, device, push, episodes)


def alike(one: dict[str, np.ndarray], other: dict[str, np.ndarray], device: str) -> None:
    """On CUDA contacts come in any order, so the last bits may differ."""
    for name, values in one.items():
        if device == "cpu":
            np.testing.assert_array_equal(values, other[name])
        elif name != "rgb":
            np.testing.assert_allclose(values, other[name], atol=1e-4)


@pytest.mark.parametrize("device", DEVICES)
def test_worlds_keep_nothing_of_an_episode(device: str) -> None:
    scene = compiled("fetch_reach")
    worlds, (episodes, actions) = DeviceWorlds(scene, view(scene), COUNT, device), drawn(scene, SHORT)
    first = play(worlds, episodes, actions)
    play(worlds, *drawn(scene, 1, seed=2))
    alike(first, play(worlds, episodes, actions), device)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("name", ["panda_2dof", "fetch_reach"])
def test_the_graph_does_what_its_kernels_do_one_by_one(
    name: str, device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = compiled(name)
    worlds, (episodes, actions) = DeviceWorlds(scene, view(scene), COUNT, device), drawn(scene, SHORT)
    graph = play(worlds, episodes, actions)
    monkeypatch.setattr(worlds, "step", lambda: one_by_one(worlds))
    alike(graph, play(worlds, episodes, actions), device)


def one_by_one(worlds: DeviceWorlds) -> None:
    with wp.ScopedDevice(worlds.device):
        worlds._frame()


def test_episodes_that_begin_alike_are_solved_once_to_the_same_bits() -> None:
    scene = compiled("panda_2dof")
    episodes = draw_episodes(scene, 3, np.random.default_rng(3)).tiled(2)
    fields = fields_at_start(scene, episodes)
    for name, values in arm_controller(scene, 6, 1).reset(episodes.start_m, episodes.target_m).items():
        np.testing.assert_array_equal(fields[name], values)


@pytest.mark.parametrize("device", DEVICES)
def test_an_action_that_is_no_number_is_told(device: str) -> None:
    scene = compiled("panda_2dof")
    episodes, actions = drawn(scene, 1)
    actions[0, 1, 0] = np.nan
    with pytest.raises(BelvedereError, match="not a number"):
        play(DeviceWorlds(scene, view(scene), COUNT, device), episodes, actions)


@pytest.mark.parametrize("device", DEVICES)
def test_too_little_room_for_what_touches_is_told(device: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device_worlds, "_CONTACTS", 1)
    scene = compiled("panda_2dof_obstacle")
    with pytest.raises(BelvedereError, match="room for 1 contacts each"):
        play(DeviceWorlds(scene, view(scene), COUNT, device), *into_the_obstacle(scene))


def test_a_frame_leaves_nothing_to_the_host(monkeypatch: pytest.MonkeyPatch) -> None:
    """No array goes through NumPy: on CUDA it would wait for the device, and could not be captured."""
    scene = compiled("panda_2dof")
    worlds, (episodes, _) = DeviceWorlds(scene, view(scene), COUNT, "cpu"), drawn(scene, 1)
    worlds.reset(episodes)

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("an array went to or came from the host")

    for name in ("numpy", "assign", "list"):
        monkeypatch.setattr(wp.array, name, refused)
    one_by_one(worlds)


def peaks(scene: Scene, episodes: int) -> tuple[int, int]:
    """The most constraints and contacts of MuJoCo's in any substep of hands that lean about."""
    rng, most = np.random.default_rng(1), [0, 0]
    env = environment(scene, rng)

    def step(nstep: int = 1) -> None:
        model, data = env.physics.model.ptr, env.physics.data.ptr
        for _ in range(nstep):
            mujoco.mj_step(model, data)
            most[:] = max(most[0], data.nefc), max(most[1], data.ncon)

    env.physics.step = step
    for _ in range(episodes):
        env.reset()
        for frame in range(scene.frames):
            if frame % 8 == 0:
                place_m = rng.uniform(*near(scene))
            way_m = (place_m - env.physics.tip())[list(scene.axes)]
            env.step(np.clip(way_m / scene.params.displacement_m, -1, 1))
    return most[0], most[1]


def near(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """The corners, m, of what to lean on: the obstacle and a little about it, or else the table."""
    if not scene.params.obstacles:
        low_m, high_m = np.asarray(scene.params.workspace.low_m), np.asarray(scene.params.workspace.high_m)
        return low_m, np.append(high_m[:2], low_m[2] + 0.1)
    box = scene.params.obstacles[0]
    half = 1.5 * np.asarray(box.half_size_m)
    return np.asarray(box.center_m) - half, np.asarray(box.center_m) + half


@pytest.mark.parametrize("name", ["panda_2dof_obstacle", "fetch_reach"])
def test_there_is_twice_the_room_that_leaning_about_needs(name: str) -> None:
    constraints, contacts = peaks(compiled(name), episodes=30)
    assert constraints > 40 and contacts > 4  # it did lean
    assert 2 * constraints <= device_worlds._CONSTRAINTS
    assert 2 * contacts <= device_worlds._CONTACTS


def test_a_solver_cut_off_is_no_lack_of_room() -> None:
    scene = compiled("panda_2dof")
    worlds = DeviceWorlds(scene, view(scene), COUNT, "cpu")
    worlds.reset(drawn(scene, 1)[0])
    worlds._data.overflow.fill_(int(OverflowType.ITERATIONS | OverflowType.LS_ITERATIONS))
    worlds.check()
    worlds._data.overflow.fill_(int(OverflowType.NEFC))
    with pytest.raises(BelvedereError, match="too much touches"):
        worlds.check()
