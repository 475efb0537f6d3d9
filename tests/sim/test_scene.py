"""Scenes: what params.yaml may say, and what compiles."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml

from pipeline.contract.errors import BelvedereError
from pipeline.contract.params import PARAMS_FILE
from pipeline.sim import robot_files
from pipeline.sim.scene import Scene, load_scene


def changed(tmp_path: Path, scene: str, **values: object) -> Path:
    """A params.yaml with values of one scene replaced; ``camera__fov_deg`` reaches into a section."""
    tree = yaml.safe_load(PARAMS_FILE.read_text())
    for name, value in values.items():
        *sections, last = name.split("__")
        node = tree["scenes"][scene]
        for section in sections:
            node = node[section]
        node[last] = value
    path = tmp_path / "params.yaml"
    path.write_text(yaml.safe_dump(tree))
    return path


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"robot": "pandaa"}, "robot 'pandaa' is unknown; available: fetch, panda"),
        ({"frames": -1}, "frames = -1 is not valid"),
        ({"camera__distance_m": 0}, "camera.distance_m = 0 is not valid"),
        ({"target__radius_m": -0.1}, "target.radius_m = -0.1 is not valid"),
        ({"axes": ["z", "y"]}, "must be some of x, y, z"),
        ({"target__candidates_m": [[0.5, 0.9, 0.2]]}, "leaves the workspace"),
        ({"colour": "red"}, "colour = 'red' is not valid"),
    ],
)
def test_bad_scenes_are_told_in_a_sentence(tmp_path: Path, values: dict[str, object], told: str) -> None:
    with pytest.raises(BelvedereError) as error:
        load_scene("panda_2dof", changed(tmp_path, "panda_2dof", **values))
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_unknown_scene_names_the_known() -> None:
    with pytest.raises(BelvedereError, match="'panda_3dof' is unknown; available: fetch_reach, panda_1dof"):
        load_scene("panda_3dof")


def test_missing_robot_file_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    class Spec:
        submodule_search_locations = (str(tmp_path),)

    monkeypatch.setattr(robot_files, "find_spec", lambda _: Spec)
    with pytest.raises(BelvedereError, match=r"robot panda: file gymnasium_robotics:.* is missing"):
        load_scene("panda_2dof")


def test_nothing_can_touch_the_target(scene: Scene) -> None:
    (number,) = scene.target_geoms
    geom = scene.model.geom(number)
    assert geom.contype == 0
    assert geom.conaffinity == 0
    assert geom.type == mujoco.mjtGeom.mjGEOM_SPHERE


def test_light_is_symmetric_about_the_vertical(scene: Scene) -> None:
    model = scene.model
    np.testing.assert_allclose(model.light_dir, [[0, 0, -1]])
    assert not model.light_castshadow.any()
    assert not np.any(model.light_specular)


def test_a_frame_is_a_25th_of_a_second(scene: Scene) -> None:
    assert scene.params.substeps * scene.model.opt.timestep == pytest.approx(1 / 25)
    assert scene.frames == 50
