"""Examples: each is one whole declaration, and the documented step puts it into params.yaml."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from examples.add import added
from pipeline.checks import home, parameters, robot
from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import named_viewpoints
from pipeline.contract.yamls import parse, read_yaml
from pipeline.rendering.visibility import refuse_hidden_targets
from pipeline.sim.draws import draw_episodes
from pipeline.sim.expert import Expert
from pipeline.sim.params import SceneParams
from pipeline.sim.robot_params import RobotParams
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds
from tests.support import ROOT

RANKINGS = sorted((ROOT / "reports/rankings").glob("*.json"))
ROBOTS = sorted((ROOT / "examples/robots").glob("*.yaml"))
PARAMS = (ROOT / "params.yaml").read_text(encoding="utf-8")


@pytest.fixture
def with_jaco(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory whose params.yaml has the example that needs no package besides."""
    text = added(PARAMS, (ROOT / "examples/robots/jaco.yaml").read_text(encoding="utf-8"))
    (tmp_path / "params.yaml").write_text(text, encoding="utf-8")
    shutil.copytree(ROOT / "robots", tmp_path / "robots")
    monkeypatch.chdir(tmp_path)
    params._tree.cache_clear()
    return tmp_path


@pytest.mark.parametrize("file", ROBOTS, ids=lambda file: file.stem)
def test_an_example_is_added_to_what_stands_in_params(file: Path) -> None:
    """The packages of most are no part of the environment: what they declare is checked but for its files."""
    example: dict[str, dict[str, Any]] = read_yaml(file)
    before, after = parse(PARAMS), parse(added(PARAMS, file.read_text(encoding="utf-8")))
    assert set(example) == {"robots", "scenes", "viewpoints"}
    for key in before:
        expected = {**example[key], **before[key]} if key in example else before[key]
        assert after[key] == expected
    for key, model in (("robots", RobotParams), ("scenes", SceneParams)):
        ((_, declared),) = example[key].items()
        model.model_validate(declared)
    ((name, declared),) = example["robots"].items()
    text = file.read_text(encoding="utf-8").split("robots:\n")[1].split("\nscenes:")[0]
    assert len(text.splitlines()) <= 10
    assert [scene["robot"] for scene in example["scenes"].values()] == [name]
    assert {view["scene"] for view in example["viewpoints"].values()} == set(example["scenes"])
    assert len(example["viewpoints"]) == 2


def test_jaco_reaches_every_target_in_sight(with_jaco: Path) -> None:
    parameters.check()
    scene = load_scene("jaco_2dof")
    for view in named_viewpoints().values():
        if view.scene == scene.name:
            refuse_hidden_targets(scene, view)
    worlds, expert = Worlds(scene, 16), Expert(scene)
    worlds.reset(draw_episodes(scene, 16, np.random.default_rng(0)))
    for _ in range(scene.frames):
        worlds.step(expert(worlds.state))
    assert np.linalg.norm(worlds.tip - worlds.target, axis=1).max() < 2e-3


def test_the_check_tells_what_a_robot_does_and_draws_it(
    with_jaco: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot.main(robot="jaco", out=Path("jaco.png"))
    said = capsys.readouterr().out
    assert "arm's joints:    joint_1, joint_2, joint_3, joint_4, joint_5, joint_6" in said
    assert "largest miss at the end is 0.0 mm" in said
    assert "a picture:" in said and "of 6000 faces" in said
    assert Path("jaco.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(BelvedereError, match="robot fetch is pulled by a weld"):
        robot.main(robot="fetch", out=Path("fetch.png"))


def test_a_home_is_found_from_which_the_arm_reaches(
    with_jaco: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    home.main(robot="jaco")
    found = parse(capsys.readouterr().out)
    file = Path("params.yaml")
    text = file.read_text(encoding="utf-8")
    former = next(line for line in text.splitlines() if "joint_1: 0.29" in line)
    file.write_text(text.replace(former, f"    home: {found['home']}"), encoding="utf-8")
    params._tree.cache_clear()
    robot.main(robot="jaco", out=Path("jaco.png"))
    assert "largest miss at the end is 0.0 mm" in capsys.readouterr().out


@pytest.mark.parametrize(
    "file", sorted((ROOT / "reports/rankings").glob("*.json")), ids=lambda file: file.stem
)
def test_a_ranking_is_read_in_a_few_lines(file: Path) -> None:
    command = [sys.executable, "examples/read_ranking.py", file.stem]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    ranking = json.loads(file.read_text(encoding="utf-8"))
    assert told[0] == ranking["answer"]["sentence"]
    assert [line.split(":")[0] for line in told[1:]] == list(ranking["viewpoints"])
