"""Align: free axes cost nothing, the tip is to be above the rim, and nothing can touch the container."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.tasks.base import State
from pipeline.sim.tasks.bodies import TARGET_GROUP
from tests.examples import example
from tests.sim.conftest import compile_changed


def changed(scene_axes: tuple[str, ...] = ("y", "z"), **task: object) -> Scene:
    params = example("align").params
    tree = params.model_dump() | {"axes": scene_axes, "task": params.task.model_dump() | task}
    return compile_changed("changed", type(params).model_validate(tree))


def test_free_axes_cost_nothing() -> None:
    task, rng = changed(axes=("y",)).task, np.random.default_rng(1)
    point, target = rng.uniform(-1, 1, (2, 50, 3))
    np.testing.assert_allclose(task.error(point, target), np.abs(point - target)[:, 1], rtol=1e-12)
    moved = point + rng.uniform(-1, 1, (50, 1)) * [1.0, 0.0, 1.0]
    np.testing.assert_allclose(task.error(moved, target), task.error(point, target), rtol=1e-12)


def test_the_expert_leaves_free_axes_alone() -> None:
    scene, rng = changed(axes=("y",)), np.random.default_rng(2)
    tip, target = rng.uniform(-1, 1, (2, 9, 3))
    aim = scene.task.aim(State(tip, tip, target, target))
    np.testing.assert_array_equal(aim[:, [0, 2]], tip[:, [0, 2]])
    np.testing.assert_array_equal(aim[:, 1], target[:, 1])


def test_the_goal_is_above_the_rim() -> None:
    scene = example("align")
    data = mujoco.MjData(scene.model)
    mujoco.mj_forward(scene.model, data)
    geoms = list(scene.target_geoms)
    tops = data.geom_xpos[geoms][:, 2] + [upper(scene, geom) for geom in geoms]
    place = data.mocap_pos[scene.target_mocap]
    assert scene.task.offset_m[2] == pytest.approx(tops.max() - place[2] + 0.06)


def upper(scene: Scene, geom: int) -> float:
    """Half the height of a geom that stands upright."""
    flat = scene.model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CYLINDER
    return float(scene.model.geom_size[geom][1 if flat else 2])


def test_where_the_scene_does_not_control_z_the_tip_starts_at_the_height_of_release() -> None:
    scene = changed(scene_axes=("y",), axes=("y",))
    episodes = draw_episodes(scene, 9, np.random.default_rng(3))
    np.testing.assert_allclose(episodes.start_m[:, 2], 0.14)


@pytest.mark.parametrize(("floor", "boxes"), [(True, 5), (False, 4)])
def test_the_container_is_open_above_and_closed_at_its_sides(floor: bool, boxes: int) -> None:
    """Straight down through the opening a ray meets marker or desk; just inside the edge a wall's rim."""
    container = example("align").params.task.container.model_dump() | {"floor": floor}
    scene = changed(container=container)
    model, data = scene.model, mujoco.MjData(scene.model)
    mujoco.mj_forward(model, data)
    kinds = model.geom_type[list(scene.target_geoms)]
    assert (kinds == mujoco.mjtGeom.mjGEOM_BOX).sum() == boxes
    assert (kinds == mujoco.mjtGeom.mjGEOM_CYLINDER).sum() == 1
    place, heights = data.mocap_pos[scene.target_mocap], {}
    for x, y in ((0, 0), (0.04, 0.04), (0.056, 0), (0, 0.056), (-0.056, 0), (0, -0.056), (0.07, 0)):
        groups = np.eye(mujoco.mjNGROUP, dtype=np.uint8)[TARGET_GROUP]
        met = np.zeros(1, np.int32)
        origin = place + np.array([x, y, 1.0])
        away = mujoco.mj_ray(model, data, origin, np.array([0, 0, -1.0]), groups, True, -1, met)
        heights[x, y] = 1.0 - away if away >= 0 else None
    assert heights[0, 0] == pytest.approx(0.011 if floor else 0.003)
    assert heights[0.04, 0.04] == (pytest.approx(0.008) if floor else None)
    for rim in ((0.056, 0), (0, 0.056), (-0.056, 0), (0, -0.056)):
        assert heights[rim] == pytest.approx(0.08)
    assert heights[0.07, 0] is None


def test_nothing_can_touch_it_and_it_stands_alone_in_its_group() -> None:
    scene, model = example("align"), example("align").model
    own = np.isin(np.arange(model.ngeom), scene.target_geoms)
    assert not model.geom_contype[own].any() and not model.geom_conaffinity[own].any()
    np.testing.assert_array_equal(model.geom_group == TARGET_GROUP, own)
