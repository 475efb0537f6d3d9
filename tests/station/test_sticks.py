"""Sticks against the camera's own matrices, as MuJoCo computes them, and against the robot's base."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import model_seen_from
from pipeline.sim.scene import CAMERA, Scene, load_scene
from pipeline.station.params import StationParams, station_params
from pipeline.station.sticks import Sticks, pushed, pushes

ANGLES = [(0, 0), (90, 45), (45, 30), (-135, 20), (200, 60)]
UP, RIGHT, REST = np.array([0.0, -1.0]), np.array([1.0, 0.0]), np.zeros(2)


@pytest.fixture(scope="module")
def fetch() -> Scene:
    return load_scene("fetch_reach")  # all three axes are free


def given(frame: str) -> StationParams:
    return station_params().model_copy(update={"frame": frame})


def seen(scene: Scene, view: Viewpoint, velocity: np.ndarray) -> np.ndarray:
    """A velocity in the camera's axes: right, up, and towards the camera."""
    model = model_seen_from(scene, view)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data.cam_xmat[model.camera(CAMERA).id].reshape(3, 3).T @ velocity


@pytest.mark.parametrize("theta, phi", ANGLES)
def test_in_the_camera_s_frame_right_is_the_picture_s_right_and_up_is_away(
    fetch: Scene, theta: float, phi: float
) -> None:
    view = Viewpoint(scene=fetch.name, theta=theta, phi=phi)
    sticks = Sticks(fetch, view, given("camera"))
    right, up = sticks.action(RIGHT, REST), sticks.action(UP, REST)
    across = seen(fetch, view, right)
    assert across[0] > 0 and across[1:] == pytest.approx([0, 0], abs=1e-9)
    away = seen(fetch, view, up)
    assert away[2] < 0 and away[0] == pytest.approx(0, abs=1e-9)
    assert up[2] == right[2] == 0  # both level
    assert np.linalg.norm(up) == pytest.approx(np.linalg.norm(right))


@pytest.mark.parametrize("theta, phi", ANGLES)
@pytest.mark.parametrize("frame", ["robot", "camera"])
def test_the_right_stick_up_is_up_wherever_the_camera_stands(
    fetch: Scene, theta: float, phi: float, frame: str
) -> None:
    view = Viewpoint(scene=fetch.name, theta=theta, phi=phi)
    action = Sticks(fetch, view, given(frame)).action(REST, UP)
    assert action[2] > 0 and action[:2] == pytest.approx([0, 0], abs=1e-12)
    assert seen(fetch, view, action)[1] > 0


@pytest.mark.parametrize("theta, phi", ANGLES)
def test_in_the_robot_s_frame_up_leads_away_from_its_base(fetch: Scene, theta: float, phi: float) -> None:
    view = Viewpoint(scene=fetch.name, theta=theta, phi=phi)
    sticks = Sticks(fetch, view, given("robot"))
    assert sticks.action(UP, REST) / sticks.action(UP, REST)[0] == pytest.approx([1, 0, 0], abs=1e-12)
    right = sticks.action(RIGHT, REST)
    assert right[1] < 0 and right[[0, 2]] == pytest.approx([0, 0], abs=1e-12)


def test_the_robot_s_frame_turns_with_the_front_of_the_scene(fetch: Scene) -> None:
    turned = fetch.params.camera.model_copy(update={"front_deg": 90})
    described = fetch.params.model_copy(update={"camera": turned})
    scene = Scene(fetch.name, described, fetch.model, fetch.robot, fetch.declared)
    view = Viewpoint(scene=fetch.name, theta=0, phi=0)
    action = Sticks(scene, view, given("robot")).action(UP, REST)
    assert action[1] > 0 and action[[0, 2]] == pytest.approx([0, 0], abs=1e-12)


def test_a_locked_axis_stays_locked() -> None:
    scene = load_scene("panda_1dof")
    sticks = Sticks(scene, Viewpoint(scene=scene.name, theta=90, phi=30), given("robot"))
    assert not sticks.action(np.array([1.0, -1.0]), np.array([1.0, 0.0])).any()
    assert sticks.action(REST, UP).shape == (1,)


def test_a_full_stick_asks_for_the_declared_speed(fetch: Scene) -> None:
    station = given("robot")
    sticks = Sticks(fetch, Viewpoint(scene=fetch.name, theta=0, phi=0), station)
    metres = np.linalg.norm(sticks.action(UP, REST)) * fetch.params.displacement_m
    assert metres * station.frames_per_second == pytest.approx(station.speed_m_s)


@pytest.mark.parametrize("dead_zone", [0.0, 0.12, 0.5])
def test_the_dead_zone_is_quiet_and_leaves_no_jump(dead_zone: float) -> None:
    lengths = np.linspace(0, 1.4, 141)
    answers = np.array([np.linalg.norm(pushed(np.array([0.6, 0.8]) * r, dead_zone)) for r in lengths])
    assert not answers[lengths <= dead_zone].any()
    assert (np.diff(answers) >= -1e-12).all() and np.diff(answers).max() <= 0.01 / (1 - dead_zone) + 1e-9
    assert answers[lengths >= 1.0] == pytest.approx(1.0)


def test_pushes_are_the_inverse_of_sticks(fetch: Scene) -> None:
    rng, station = np.random.default_rng(3), given("camera")
    for theta, phi in ANGLES:
        sticks = Sticks(fetch, Viewpoint(scene=fetch.name, theta=theta, phi=phi), station)
        wanted = rng.uniform(-0.5, 0.5, 3)
        action = sticks.action(*pushes(sticks.to_world, wanted, station.dead_zone))
        share = station.speed_m_s / station.frames_per_second / fetch.params.displacement_m
        assert action == pytest.approx(wanted * share)
