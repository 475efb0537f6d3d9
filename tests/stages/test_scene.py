"""What decides a scene, written down: the stages behind it run again when a file of the robot changes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline import scene
from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from tests.sim.arms import HOME, mjcf, obj
from tests.support import ROOT

PART = '<asset><mesh name="part" file="part.obj"/></asset>'


@pytest.fixture
def declared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository's params.yaml with two robots of its own and a scene of each."""
    tree: dict[str, Any] = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
    for name in ("one", "two"):
        (tmp_path / "robots" / name).mkdir(parents=True)
        text = mjcf(hand='<geom type="mesh" mesh="part"/>', other=PART)
        (tmp_path / "robots" / name / "arm.xml").write_text(text)
        (tmp_path / "robots" / name / "part.obj").write_text(obj(2))
        tree["robots"][name] = {"file": f"robots/{name}/arm.xml", "tip": {"site": "grip"}, "home": HOME}
        tree["scenes"][name] = tree["scenes"]["panda_2dof"] | {"robot": name, "desk": None}
    (tmp_path / "params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    params._tree.cache_clear()
    return tmp_path


def written(name: str) -> dict[str, Any]:
    out = Path(f"data/scenes/{name}.json")
    scene.main(scene=name, robots=Path("robots"), out=out)
    return dict(json.loads(out.read_text(encoding="utf-8")))


def test_it_holds_both_declarations_and_every_file(declared: Path) -> None:
    content = written("one")
    assert content["name"] == "one" and content["scene"]["robot"] == "one"
    assert content["robot"]["home"] == HOME and content["robot"]["drive"]["frequency_hz"] == 4.0
    assert set(content["files"]) == {"arm.xml", "part.obj"}
    assert str(declared) not in json.dumps(content)


def test_a_changed_mesh_changes_its_own_scene_only(declared: Path) -> None:
    before = {name: written(name) for name in ("one", "two", "panda_2dof")}
    mesh = declared / "robots/one/part.obj"
    mesh.write_text(mesh.read_text().replace("0.03", "0.02"))
    after = {name: written(name) for name in before}
    assert {name for name in before if after[name] != before[name]} == {"one"}


def test_a_missing_mesh_is_told_and_nothing_is_written(declared: Path) -> None:
    (declared / "robots/one/part.obj").unlink()
    with pytest.raises(BelvedereError, match=r"robot one: mesh part\.obj, .* is missing: .* has arm\.xml"):
        written("one")
    assert not Path("data/scenes/one.json").exists()
