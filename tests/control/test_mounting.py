"""Cameras off their places: where they stand, by geometry, and that none at all changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.contract.viewpoints import Viewpoint
from pipeline.control.mounting import Offset, offsets, standing_off
from pipeline.control.params import MountingParams
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import Scene, load_scene

VIEW = Viewpoint(scene="panda_2dof", theta=30, phi=20)
DECLARED = MountingParams(turns_deg=(1, 5), moves_m=(0.05,), episodes=4, repeats=2)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("panda_2dof")


def pose(scene: Scene, off: Offset) -> tuple[np.ndarray, np.ndarray]:
    there, view = standing_off(scene, VIEW, off)
    return camera_to_world(there.params.camera, view)


def test_each_turn_and_move_goes_both_ways_on_each_axis() -> None:
    found = list(offsets(DECLARED))
    assert found[0] == Offset() and len(found) == len(set(found)) == 1 + 2 * 4 + 6
    assert {off.turn_deg for off in found} == {0, 1, 5}
    assert sorted({off.move_m for off in found}) == pytest.approx([0, 0.05])


def test_no_offset_is_the_place_itself(scene: Scene) -> None:
    assert standing_off(scene, VIEW, Offset()) == (scene, VIEW)


@pytest.mark.parametrize("off", [off for off in offsets(DECLARED) if off.move_m])
def test_a_moved_camera_looks_the_same_way_from_beside(scene: Scene, off: Offset) -> None:
    before, rotation = pose(scene, Offset())
    after, turned = pose(scene, off)
    np.testing.assert_allclose(turned, rotation)
    np.testing.assert_allclose(rotation.T @ (after - before), [off.right_m, off.up_m, off.back_m], atol=1e-12)


@pytest.mark.parametrize("off", [off for off in offsets(DECLARED) if off.turn_deg])
def test_a_turned_camera_still_looks_at_the_middle_from_as_far(scene: Scene, off: Offset) -> None:
    middle = np.asarray(scene.params.camera.look_at_m)
    before, _ = pose(scene, Offset())
    after, rotation = pose(scene, off)
    np.testing.assert_allclose(np.cross(rotation[:, 2], after - middle), 0, atol=1e-12)
    assert np.linalg.norm(after - middle) == pytest.approx(scene.params.camera.distance_m)
    between = np.degrees(np.arccos((before - middle) @ (after - middle) / scene.params.camera.distance_m**2))
    share = np.cos(np.radians(VIEW.phi)) if off.theta_deg else 1.0
    assert between == pytest.approx(off.turn_deg * share, rel=2e-3)
