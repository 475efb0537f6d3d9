"""The section of the station, held against the scenes that it names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.yamls import read_yaml
from pipeline.station.params import station_params
from pipeline.station.stage import compared_views
from tests.support import ROOT


def written(folder: Path, **changed: Any) -> Path:
    tree = read_yaml(ROOT / params.PARAMS_FILE)
    tree["station"] |= changed
    tree["scenes"]["odd"] = {**tree["scenes"]["panda_1dof"], "substeps": 10}
    path = {"radius_m": [0, 0.02, 0.02], "cycles": [1, 1, 1], "phase_deg": [0, 0, 90], "period_s": 2.0}
    task = {"kind": "follow", "hold_frames": 5, **path}
    tree["scenes"]["following"] = {**tree["scenes"]["panda_2dof"], "task": task}
    file = folder / params.PARAMS_FILE
    file.write_text(yaml.safe_dump(tree, allow_unicode=True), encoding="utf-8")
    return file


@pytest.mark.parametrize(
    "changed, told",
    [
        ({"tasks": ["moon"]}, "moon"),
        ({"tasks": ["following"]}, "its task is follow"),
        ({"tasks": ["odd"]}, "frames_per_second"),
        ({"tasks": ["panda_1dof", "panda_1dof"]}, "twice"),
        ({"frames_per_second": 30}, "25 frames a second"),
        ({"practice_s": [10, 5]}, "shortest"),
        ({"picture": [650, 480]}, "picture"),
        ({"frame": "world"}, "frame"),
        ({"renderer": "vulkan"}, "renderer"),
        ({"dead_zone": 1.0}, "dead_zone"),
    ],
)
def test_a_value_that_does_not_fit_is_told_in_a_sentence(
    changed: dict[str, Any], told: str, tmp_path: Path
) -> None:
    with pytest.raises(BelvedereError, match=told) as error:
        station_params(written(tmp_path, **changed))
    assert "\n" not in str(error.value)


def test_a_scene_without_a_viewpoint_is_refused(tmp_path: Path) -> None:
    tree = read_yaml(ROOT / params.PARAMS_FILE)
    tree["viewpoints"] = {k: v for k, v in tree["viewpoints"].items() if v["scene"] != "panda_1dof"}
    path = tmp_path / params.PARAMS_FILE
    path.write_text(yaml.safe_dump(tree, allow_unicode=True), encoding="utf-8")
    with pytest.raises(BelvedereError, match="no viewpoint"):
        station_params(path)


def test_the_compared_views_are_a_scene_s_first_ones_or_the_chosen() -> None:
    given = station_params()
    assert {scene: list(views) for scene, views in compared_views(given, None).items()} == {
        scene: [f"{scene}-a", f"{scene}-b"] for scene in given.tasks
    }
    one = given.model_copy(update={"tasks": ("fetch_reach",)})
    chosen = compared_views(one, ["fetch_reach-e", "fetch_reach-c"])
    assert set(chosen["fetch_reach"]) == {"fetch_reach-c", "fetch_reach-e"}
    with pytest.raises(BelvedereError, match="unknown"):
        compared_views(one, ["panda_2dof-a"])
    with pytest.raises(BelvedereError, match="without a view"):
        compared_views(given, ["panda_2dof-a"])
