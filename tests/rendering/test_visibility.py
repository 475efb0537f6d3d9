"""What a camera sees, against MuJoCo's own rays; views from which a target position is hidden."""

from __future__ import annotations

import copy
import itertools

import mujoco
import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint, viewpoint
from pipeline.rendering.visibility import PICTURE_SIZE, Sight, refuse_hidden_targets
from pipeline.sim.camera import camera_to_world
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds
from tests.sim.conftest import compile_changed, compiled


def with_obstacle(center_m: tuple[float, ...], half_size_m: tuple[float, ...]) -> Scene:
    """Scene panda_2dof_obstacle with its obstacle elsewhere."""
    params = compiled("panda_2dof_obstacle").params
    tree = params.model_dump() | {"obstacles": [{"center_m": center_m, "half_size_m": half_size_m}]}
    return compile_changed("moved", type(params).model_validate(tree))


def refused(scene: Scene, view: Viewpoint) -> bool:
    try:
        refuse_hidden_targets(scene, view)
    except BelvedereError:
        return True
    return False


def test_no_candidate_view_is_refused(view: Viewpoint) -> None:
    refuse_hidden_targets(compiled(view.scene), view)


def test_an_obstacle_before_a_target_is_told_with_place_view_and_remedy() -> None:
    between = (0.65, 0.09, 0.185)  # the second target and a camera at (0, 0)
    scene = with_obstacle(between, (0.01, 0.05, 0.05))
    with pytest.raises(BelvedereError) as error:
        refuse_hidden_targets(scene, viewpoint("moved", 0, 0))
    told = str(error.value)
    assert "viewpoint (0°, 0°) obstacle0 hides the whole target at [0.5, 0.11, 0.175] m" in told
    assert "scenes.moved" in told and "\n" not in told
    refuse_hidden_targets(scene, viewpoint("moved", 90, 0))
    refuse_hidden_targets(with_obstacle(between, (0.01, 0.02, 0.02)), viewpoint("moved", 0, 0))


def test_desk_and_the_pictures_edge_are_told() -> None:
    with pytest.raises(BelvedereError, match="desk hides the whole target"):
        refuse_hidden_targets(compiled("panda_2dof"), viewpoint("panda_2dof", 0, -30))
    params = compiled("panda_2dof").params
    elsewhere = params.camera.model_copy(update={"look_at_m": (0.5, 1.5, 0.2)})
    scene = compile_changed("turned", params.model_copy(update={"camera": elsewhere}))
    with pytest.raises(BelvedereError, match="the picture's edge cuts off the whole target"):
        refuse_hidden_targets(scene, viewpoint("turned", 0, 0))


def test_refused_is_where_no_ray_of_mujocos_meets_the_target() -> None:
    """Every pixel's ray, cast by MuJoCo in the scene without the robot; views and obstacles at random."""
    rng, verdicts = np.random.default_rng(3), []
    params = compiled("panda_2dof_obstacle").params
    for candidate in params.target.candidates_m * 10:
        view = viewpoint("moved", rng.uniform(-30, 60), rng.uniform(-15, 40))
        camera, _ = camera_to_world(params.camera, view)
        place = candidate + rng.uniform(0.15, 0.5) * (camera - candidate) + rng.uniform(-0.03, 0.03, 3)
        scene = with_obstacle(tuple(place), tuple(rng.uniform(0.02, 0.06, 3)))
        fewest = min(pixels_of(scene, view, np.array(c)) for c in scene.params.target.candidates_m)
        assert refused(scene, view) == (fewest == 0)
        verdicts.append(fewest == 0)
    assert 10 < sum(verdicts) < 30


def pixels_of(scene: Scene, view: Viewpoint, target_m: np.ndarray) -> int:
    model = copy.copy(scene.model)
    robot = [model.body(b).name.startswith(scene.robot.prefix) for b in model.geom_bodyid]
    model.geom_group[robot] = 5
    data = mujoco.MjData(model)
    data.mocap_pos[scene.target_mocap] = target_m
    mujoco.mj_forward(model, data)
    origin, rotation = camera_to_world(scene.params.camera, view)
    slope = np.tan(np.radians(scene.params.camera.fov_deg) / 2)
    across = ((np.arange(PICTURE_SIZE) + 0.5) / PICTURE_SIZE * 2 - 1) * slope
    rays = np.array([(x, y, -1.0) for x, y in itertools.product(across, across)]) @ rotation.T
    met, far = np.zeros(len(rays), np.int32), np.zeros(len(rays))
    groups = np.array([1, 1, 1, 0, 0, 0], np.uint8)
    flat = rays.reshape(-1, 1)
    mujoco.mj_multiRay(model, data, origin, flat, groups, True, -1, met, far, None, len(rays), 10.0)
    return int(np.isin(met, scene.target_geoms).sum())


def test_a_target_behind_the_camera_is_in_no_pixel() -> None:
    scene = compiled("panda_2dof")
    episodes = draw_episodes(scene, 4, np.random.default_rng(8))
    worlds = Worlds(scene, 4)
    worlds.reset(episodes)
    behind = episodes.target_m + np.array([3.0, 0.0, 0.0])  # behind a camera in front of the robot
    assert Sight(scene, 4).target_pixels(viewpoint(scene.name, 0, 0), worlds.qpos, behind).max() == 0
