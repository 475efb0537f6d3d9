"""Viewpoints: geometry against MuJoCo's own camera, and bad angles."""

from __future__ import annotations

import itertools
import math

import mujoco
import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint, viewpoint
from pipeline.rendering.renderer import model_seen_from
from pipeline.rendering.visibility import to_pixels
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import CAMERA, Scene, load_scene, with_camera


def test_theta_zero_looks_along_x_from_the_front(scene: Scene) -> None:
    position, rotation = camera_to_world(scene.params.camera, viewpoint(scene.name, 0, 0))
    np.testing.assert_allclose(-rotation[:, 2], [-1, 0, 0], atol=1e-12)  # looks back at the robot
    np.testing.assert_allclose(rotation[:, 1], [0, 0, 1], atol=1e-12)
    assert position[0] > scene.params.camera.look_at_m[0]


@pytest.mark.parametrize(("theta", "phi"), list(itertools.product((0, 45, 90, -130), (0, 30, -60, 89))))
def test_pose_is_rigid_and_looks_at_the_point(scene: Scene, theta: float, phi: float) -> None:
    position, rotation = camera_to_world(scene.params.camera, viewpoint(scene.name, theta, phi))
    np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)
    to_point = np.asarray(scene.params.camera.look_at_m) - position
    assert np.linalg.norm(to_point) == pytest.approx(scene.params.camera.distance_m)
    np.testing.assert_allclose(to_point / np.linalg.norm(to_point), -rotation[:, 2], atol=1e-12)
    assert math.degrees(math.asin(rotation[2, 2])) == pytest.approx(phi)


@pytest.mark.parametrize("theta", [0, 45, 90, 360])
def test_a_full_turn_is_the_same_viewpoint(scene: Scene, theta: float) -> None:
    views = [viewpoint(scene.name, each, 30) for each in (theta, theta - 360)]
    assert views[0].place == views[1].place
    for one, other in zip(*(camera_to_world(scene.params.camera, each) for each in views), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_mujoco_places_its_camera_where_we_say(view: Viewpoint) -> None:
    scene = load_scene(view.scene)
    model = model_seen_from(scene, view)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    position, rotation = camera_to_world(scene.params.camera, view)
    np.testing.assert_allclose(data.camera(CAMERA).xpos, position, atol=1e-9)
    np.testing.assert_allclose(data.camera(CAMERA).xmat.reshape(3, 3), rotation, atol=1e-9)


def test_workspace_corners_and_target_lie_in_every_candidates_picture(view: Viewpoint) -> None:
    scene = load_scene(view.scene)
    low, high = np.array(scene.params.workspace.low_m), np.array(scene.params.workspace.high_m)
    corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
    pixels = to_pixels(scene, view, corners, 64)
    assert pixels.min() > 0
    assert pixels.max() < 64
    goal_low = np.min(scene.params.target.candidates_m, axis=0) - scene.params.target.jitter_m
    goal_high = np.max(scene.params.target.candidates_m, axis=0) + scene.params.target.jitter_m
    goals = np.array(list(itertools.product(*zip(goal_low, goal_high, strict=True))))
    focal = 32 / np.tan(np.radians(scene.params.camera.fov_deg) / 2)
    position, rotation = camera_to_world(scene.params.camera, view)
    radius = focal * scene.params.target.radius_m / ((position - goals) @ rotation[:, 2])
    middle = to_pixels(scene, view, goals, 64)
    assert (middle - radius[:, None]).min() > 0
    assert (middle + radius[:, None]).max() < 64


@pytest.mark.parametrize(
    ("theta", "phi", "named"),
    [(math.nan, 0, "theta = nan"), (0, math.inf, "phi = inf"), (0, 90, "phi = 90"), (0, -90, "phi = -90")],
)
def test_bad_angles_are_told(theta: float, phi: float, named: str) -> None:
    with pytest.raises(BelvedereError, match=named):
        viewpoint("panda_1dof", theta, phi)


def test_a_camera_of_one_s_own_leaves_the_scene_as_it_is() -> None:
    scene = load_scene("panda_2dof")
    own = with_camera(scene, 2.5, 30)
    position, _ = camera_to_world(own.params.camera, viewpoint(scene.name, 20, 30))
    assert np.linalg.norm(position - np.asarray(scene.params.camera.look_at_m)) == pytest.approx(2.5)
    camera = scene.model.camera(CAMERA).id
    assert (own.model.cam_fovy[camera], scene.model.cam_fovy[camera]) == (30, scene.params.camera.fov_deg)
    assert own.cache_key != scene.cache_key and with_camera(scene, 0, 0) is scene


@pytest.mark.parametrize(("distance", "fov"), [(-1.0, 0.0), (0.0, 175.0), (math.nan, 0.0)])
def test_a_camera_that_none_can_be_is_told(distance: float, fov: float) -> None:
    with pytest.raises(BelvedereError, match="is not valid; the distance is above 0 m"):
        with_camera(load_scene("panda_2dof"), distance, fov)
