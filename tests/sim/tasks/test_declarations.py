"""A task that does not fit its scene is told in one sentence, before anything is computed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.sim.params import SceneParams
from pipeline.sim.tasks import REACH
from tests.examples import KINDS
from tests.support import ROOT

PUCK = {"radius_m": 0.03, "half_height_m": 0.03, "mass_kg": 0.1, "friction_n": 1.0, "damping_ns_per_m": 2.0}


def read(folder: Path, kind: str, scene: dict[str, Any], task: dict[str, Any]) -> SceneParams:
    """The example of a kind with other values, read as the stages read it."""
    tree = yaml.safe_load((ROOT / f"examples/tasks/{kind}.yaml").read_text(encoding="utf-8"))
    declared = tree["scenes"][f"panda_{kind}"] | scene
    declared["task"] |= task
    file = folder / "params.yaml"
    file.write_text(yaml.safe_dump({"scenes": {"mine": declared}}), encoding="utf-8")
    return params.section(SceneParams, "scenes", "mine", path=file)


@pytest.mark.parametrize(
    ("kind", "scene", "task", "told"),
    [
        ("align", {}, {"kind": "juggle"}, r"scenes\.mine\.task .*'align', 'follow', 'push'"),
        ("align", {}, {"axes": ["x"]}, r"task.axes \['x'\] has x, which the scene does not control"),
        ("align", {}, {"above_m": 0.5}, r"and the task's \+0.58 m leaves the workspace .* on axis z"),
        (
            "align",
            {},
            {"container": {"half_size_m": [0.05, 0.05, 0.05], "wall_m": 0.05, "floor": True}},
            "no opening",
        ),
        (
            "align",
            {},
            {"container": {"half_size_m": [0.05, 0.05, 0.01], "wall_m": 0.02, "floor": True}},
            "fills",
        ),
        ("follow", {}, {"radius_m": [0.1, 0.1, 0.0]}, "along x, which the scene does not control"),
        ("follow", {}, {"radius_m": [0.0, 0.0, 0.0]}, "for that there is kind reach"),
        (
            "follow",
            {},
            {"radius_m": [0.0, 0.2, 0.0]},
            r"the task's ± 0.2 m leaves the workspace .* on axis y",
        ),
        ("follow", {}, {"hold_frames": 51}, "more than the 50 frames"),
        ("follow", {}, {"period_s": 0}, r"scenes\.mine\.task\.follow\.period_s = 0 .*greater than 0"),
        (
            "follow",
            {"obstacles": [{"center_m": [0.5, 0.0, 0.1], "half_size_m": [0.01, 0.01, 0.1]}]},
            {},
            "task follow takes none",
        ),
        ("push", {"axes": ["x"]}, {}, r"axes must be \[x, y\], not \['x'\]"),
        (
            "push",
            {},
            {"puck": PUCK | {"low_m": [0.3, 0.0], "high_m": [0.5, 0.0]}},
            "no range from low_m 0.3 .*axis x",
        ),
        (
            "push",
            {},
            {"puck": PUCK | {"low_m": [0.5, 0.1], "high_m": [0.5, 0.0]}},
            "no range from low_m 0.1 .*axis y",
        ),
        (
            "push",
            {"workspace": {"low_m": [0.36, -0.19, 0.05], "high_m": [0.64, 0.19, 0.05]}},
            {},
            "on axis x",
        ),
    ],
)
def test_what_does_not_fit_is_told(
    tmp_path: Path, kind: str, scene: dict[str, Any], task: dict[str, Any], told: str
) -> None:
    with pytest.raises(BelvedereError, match=told) as error:
        read(tmp_path, kind, scene, task)
    assert "\n" not in str(error.value) and "scenes.mine" in str(error.value)


def test_goals_of_a_puck_lie_in_one_plane(tmp_path: Path) -> None:
    target = {"candidates_m": [[0.6, 0.0, 0.0], [0.6, 0.0, 0.1]], "jitter_m": [0, 0, 0], "radius_m": 0.03}
    with pytest.raises(BelvedereError, match=r"z of \[0.0, 0.1\] m"):
        read(tmp_path, "push", {"target": target}, {})


@pytest.mark.parametrize("kind", KINDS)
def test_the_examples_are_read_and_a_scene_without_a_task_reaches(tmp_path: Path, kind: str) -> None:
    assert read(tmp_path, kind, {}, {}).task.kind == kind
    tree = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))["scenes"]
    for name, scene in tree.items():
        assert "task" not in scene
        assert params.section(SceneParams, "scenes", name, path=ROOT / "params.yaml").task == REACH
