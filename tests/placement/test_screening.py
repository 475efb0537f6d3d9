"""What geometry rules out, in the real scenes: boxes, the picture's edge, and what hides a target."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.contract.viewpoints import Viewpoint
from pipeline.placement.params import Forbidden
from pipeline.placement.places import Place
from pipeline.placement.screening import Screen, fault, workspace_corners
from pipeline.rendering.visibility import to_pixels
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import Scene, load_scene, with_camera
from pipeline.storage.candidates import Candidate
from tests.placement.declared import HALF

FRONT = Viewpoint(scene="panda_2dof", theta=0, phi=20)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("panda_2dof")


def box(center: np.ndarray, half: float = 0.05, name: str = "a wall") -> Forbidden:
    return Forbidden(name=name, center_m=tuple(center), half_size_m=(half, half, half))


def test_the_paper_s_views_have_nothing_against_them(scene: Scene) -> None:
    for theta in (0, 90):
        assert fault(scene, Viewpoint(scene="panda_2dof", theta=theta, phi=0), ()) is None


def test_a_camera_in_a_forbidden_box_is_ruled_out_by_name(scene: Scene) -> None:
    camera, _ = camera_to_world(scene.params.camera, FRONT)
    assert fault(scene, FRONT, [box(camera)]) == "the camera would stand in a wall"
    assert fault(scene, FRONT, [box(camera + np.array([0, 0.2, 0]))]) is None


def test_a_box_between_camera_and_target_is_ruled_out(scene: Scene) -> None:
    camera, _ = camera_to_world(scene.params.camera, FRONT)
    target = np.array(scene.params.target.candidates_m[0])
    middle = (camera + target) / 2
    assert fault(scene, FRONT, [box(middle, 0.02)]) == "a wall stands between the camera and a target"
    assert fault(scene, FRONT, [box(target - (camera - target) * 0.5, 0.02)]) is None  # behind the target
    assert fault(scene, FRONT, [box(camera + (camera - target) * 0.5, 0.02)]) is None  # behind the camera


def test_a_workspace_that_does_not_fit_into_the_picture_is_ruled_out(scene: Scene) -> None:
    assert fault(with_camera(scene, 0, 15.0), FRONT, ()) == (
        "a target at a corner of the workspace is out of the picture"
    )
    assert fault(with_camera(scene, 0, 60.0), FRONT, ()) is None


def test_what_is_in_the_picture_agrees_with_where_points_appear(scene: Scene) -> None:
    corners = workspace_corners(scene)
    assert len(corners) == 4  # x is fixed
    for fov in (15.0, 20.0, 25.0, 30.0, 40.0):
        narrow = with_camera(scene, 0, fov)
        pixels = to_pixels(narrow, FRONT, corners, 64)
        seen = bool(((pixels >= 0) & (pixels <= 64)).all())
        assert (fault(narrow, FRONT, ()) is None) == seen


def test_from_below_the_desk_hides_the_targets(scene: Scene) -> None:
    below = Viewpoint(scene="panda_2dof", theta=0, phi=-60)
    assert fault(scene, below, ()) == "something fixed in the scene hides a target wholly"


def test_a_screen_remembers_what_it_ruled_out_and_why(scene: Scene) -> None:
    screen = Screen(scene, HALF.model_copy(update={"phi_deg": (-70, 75)}))
    camera = scene.params.camera
    above, below = (Place(0, phi, camera.distance_m, camera.fov_deg) for phi in (20, -60))
    assert screen.allowed(above) and not screen.allowed(below)
    assert screen.faults == {below: "something fixed in the scene hides a target wholly"}


def test_a_screen_looks_through_the_place_s_own_camera(scene: Scene) -> None:
    screen, far = Screen(scene, HALF), scene.params.camera.distance_m
    assert screen.allowed(Place(0, 20, far, 40)) and not screen.allowed(Place(0, 20, far, 15))
    assert screen.allowed(Place(0, 20, 4 * far, 15))


@pytest.mark.parametrize(
    ("theta", "phi", "within"), [(0, 20, True), (350, 20, True), (100, 20, False), (0, 80, False)]
)
def test_a_pan_counts_a_full_turn_on(scene: Scene, theta: float, phi: float, within: bool) -> None:
    camera = scene.params.camera
    own = {"distance_m": camera.distance_m, "fov_deg": camera.fov_deg}
    assert Screen(scene, HALF).within(Candidate(scene=scene.name, theta=theta, phi=phi, **own)) is within


def test_a_candidate_of_another_camera_stays_only_where_a_range_has_it(scene: Scene) -> None:
    fov = scene.params.camera.fov_deg
    near = Candidate(scene=scene.name, theta=0, phi=20, distance_m=1.25, fov_deg=fov)
    assert not Screen(scene, HALF).within(near)
    assert Screen(scene, HALF.model_copy(update={"distance_m": (1, 2)})).within(near)
    assert not Screen(scene, HALF.model_copy(update={"distance_m": (1.3, 2)})).within(near)
