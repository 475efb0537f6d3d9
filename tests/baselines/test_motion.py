"""The image Jacobian against finite differences, and against where the renderer puts a moved target."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.baselines.motion import image_jacobian, singular_values
from pipeline.contract import params
from pipeline.contract.viewpoints import viewpoint
from pipeline.rendering.renderer import Renderer
from pipeline.rendering.visibility import to_pixels
from pipeline.sim.scene import initial_data, load_scene

VIEWS = tuple(params.value("viewpoints").values())


@pytest.mark.parametrize("place", VIEWS, ids=lambda p: f"{p['scene']}({p['theta']},{p['phi']})")
def test_it_is_the_derivative_of_the_projection(place: dict) -> None:
    scene, view = load_scene(place["scene"]), viewpoint(place["scene"], place["theta"], place["phi"])
    points = np.asarray(scene.params.camera.look_at_m) + np.random.default_rng(1).uniform(
        -0.15, 0.15, (20, 3)
    )
    found, step_m = image_jacobian(scene, view, points, 64), 1e-5
    for column, axis in enumerate(scene.axes):
        moved = np.zeros(3)
        moved[axis] = step_m
        ahead, behind = (to_pixels(scene, view, points + sign * moved, 64) for sign in (1, -1))
        np.testing.assert_allclose(found[:, :, column], (ahead - behind) / (2 * step_m), rtol=1e-5, atol=1e-5)


def test_it_is_how_the_rendered_target_moves() -> None:
    scene, view = load_scene("panda_2dof"), viewpoint("panda_2dof", 30, 10)
    images = Renderer(scene, view, 2, size=512, groups=(1,))
    qpos = np.repeat(initial_data(scene).qpos[None], 2, axis=0)
    place = np.asarray(scene.params.target.candidates_m[0])
    for column, axis in enumerate(scene.axes):
        step = np.zeros(3)
        step[axis] = 0.02
        pictures = images.render(qpos, np.stack([place - step, place + step])).astype(float)
        red = pictures[..., 0] > pictures[..., 2] + 60
        middles = [np.argwhere(mask).mean(axis=0)[::-1] for mask in red]
        expected = image_jacobian(scene, view, place[None], 512)[0, :, column] * 0.04
        np.testing.assert_allclose(middles[1] - middles[0], expected, atol=1.0)


def test_an_axis_along_the_line_of_sight_is_all_but_lost() -> None:
    scene = load_scene("panda_2dof")
    middle = np.asarray(scene.params.camera.look_at_m)[None]
    front, side = (
        singular_values(image_jacobian(scene, viewpoint("panda_2dof", theta, 0), middle, 64))[0]
        for theta in (0, 90)
    )
    focal = 32 / np.tan(np.radians(scene.params.camera.fov_deg) / 2)
    np.testing.assert_allclose(front, focal / scene.params.camera.distance_m)
    assert side[0] == pytest.approx(front[0]) and side[1] == pytest.approx(0, abs=1e-9)
