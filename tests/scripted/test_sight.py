"""What a view resolves: against the formula, against pictures measured with errors, and by its laws."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from pipeline.contract.viewpoints import viewpoint
from pipeline.rendering.visibility import to_pixels
from pipeline.scripted.params import OperatorParams
from pipeline.scripted.sight import look_error, place_covariance
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import Scene, load_scene
from tests.support import ROOT

SIZE = 480
PARAMS = OperatorParams(**yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))["operator"])


@pytest.fixture(scope="module")
def reach() -> Scene:
    return load_scene("panda_2dof")


@pytest.fixture(scope="module")
def fetch() -> Scene:
    return load_scene("fetch_reach")


def focal(scene: Scene) -> float:
    return float(SIZE / 2 / np.tan(np.radians(scene.params.camera.fov_deg) / 2))


def test_across_the_line_of_sight_a_pixel_along_it_twelve_times_as_much(reach: Scene) -> None:
    """From (0°, 0°) y and z lie across; from (90°, 0°) y lies along. At the look-at point, 0.85 m away."""
    centre, depth = np.array([reach.params.camera.look_at_m]), reach.params.camera.distance_m
    across, diameter = depth / focal(reach), 2 * reach.params.target.radius_m
    along = np.sqrt(2) * depth**2 / (focal(reach) * diameter)
    front = place_covariance(reach, viewpoint("panda_2dof", 0, 0), SIZE, centre)[0]
    assert np.sqrt(np.diag(front)) == pytest.approx([across, across])
    side = place_covariance(reach, viewpoint("panda_2dof", 90, 0), SIZE, centre)[0]
    assert np.sqrt(np.diag(side)) == pytest.approx([along, across])
    assert along / across == pytest.approx(np.sqrt(2) * depth / diameter) and 12 < along / across < 12.1


@pytest.mark.parametrize(("theta", "phi"), [(0, 0), (45, 30), (90, 45), (-120, 10)])
def test_it_is_what_fitting_places_to_erring_pictures_gives(fetch: Scene, theta: float, phi: float) -> None:
    """Columns, rows and sizes as the renderer's projection has them, with errors; places fitted by least
    squares on the three controlled axes scatter as the covariance says."""
    view, rng = viewpoint("fetch_reach", theta, phi), np.random.default_rng(1)
    place = np.array(fetch.params.camera.look_at_m) + np.array([0.05, -0.08, 0.06])
    position, rotation = camera_to_world(fetch.params.camera, view)

    def picture(points: np.ndarray) -> np.ndarray:
        depth = -((points - position) @ rotation)[:, 2]
        size = focal(fetch) * 2 * fetch.params.target.radius_m / depth
        return np.column_stack([to_pixels(fetch, view, points, SIZE), size])

    step = 1e-6 * np.eye(3)
    slopes = (picture(place + step) - picture(place - step)).T / 2e-6
    errors = rng.normal(size=(20_000, 3)) * [0.01, 0.01, 0.01 * np.sqrt(2)]
    places = np.linalg.solve(slopes, errors.T).T  # three numbers and three axes: the fit is exact
    wanted = 0.01**2 * place_covariance(fetch, view, SIZE, place[None])[0]
    scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    assert np.cov(places.T) / scale == pytest.approx(wanted / scale, abs=0.03)


def test_knowing_which_axes_are_free_helps(fetch: Scene, reach: Scene) -> None:
    """On fewer axes the same picture leaves less open; never more."""
    view = viewpoint("fetch_reach", 40, 20)
    points = np.array([fetch.params.camera.look_at_m])
    free = place_covariance(fetch, view, SIZE, points)[0]
    information = np.linalg.inv(free)
    for axis in range(3):
        assert 1 / information[axis, axis] <= free[axis, axis] + 1e-15


def test_a_larger_picture_resolves_more_and_no_blur_is_no_error(reach: Scene) -> None:
    view, points = viewpoint("panda_2dof", 30, 20), np.array([[0.5, 0.1, 0.2]])
    small, large = (place_covariance(reach, view, size, points) for size in (240, 480))
    assert small == pytest.approx(4 * large)
    exact = PARAMS.model_copy(update={"blur_px": 0.0})
    assert (look_error(reach, view, exact, points, points) == 0).all()


def test_tip_and_target_both_err(reach: Scene) -> None:
    view = viewpoint("panda_2dof", 30, 20)
    tip, target = np.array([[0.5, -0.1, 0.3]]), np.array([[0.5, 0.08, 0.15]])
    factor = look_error(reach, view, PARAMS, tip, target)[0]
    wanted = sum(place_covariance(reach, view, PARAMS.picture_px, at)[0] for at in (tip, target))
    assert factor @ factor.T == pytest.approx(PARAMS.blur_px**2 * wanted)
