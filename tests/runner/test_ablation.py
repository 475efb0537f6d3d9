"""`./run ablation`: which viewpoints it takes, what DVC reads, and what the report gets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.contract.errors import BelvedereError
from runner import ablation
from runner.ablation import FOUND, PUBLISHED, VIEWS_FILE, chosen, declare, main, publish

NEAR = ["near-a", "near-b", "study"]


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_params()


def write_params(**others: dict[str, Any]) -> None:
    views = {
        "near-a": {"scene": "near", "theta": 0, "phi": 0},
        "near-b": {"scene": "near", "theta": 90, "phi": 0},
    }
    views["far-a"] = {"scene": "far", "theta": 0, "phi": 0}
    tree = {"viewpoint": {"scene": "near", "theta": 45, "phi": 15}, "viewpoints": views | others}
    Path("params.yaml").write_text(yaml.safe_dump(tree))


def declared() -> dict[str, Any]:
    return yaml.safe_load(VIEWS_FILE.read_text(encoding="utf-8"))["views"]


def test_without_names_all_of_the_scene_are_tried_and_with_names_those() -> None:
    assert sorted(chosen("near", [])) == NEAR
    assert list(chosen("near", ["near-b"])) == ["near-b"]


@pytest.mark.parametrize(
    ("scene", "keys", "told"),
    [("moon", [], "'moon'.*far.*near"), ("near", ["far-a"], "'far-a'.*near-a.*study")],
)
def test_what_there_is_not_is_told(scene: str, keys: list[str], told: str) -> None:
    with pytest.raises(BelvedereError, match=told):
        chosen(scene, keys)


def test_viewpoints_tried_before_stay_as_long_as_they_are_there() -> None:
    declare(chosen("near", []))
    declare(chosen("far", []))
    assert sorted(declared()) == sorted([*NEAR, "far-a"])
    assert declared()["near-b"] == {"scene": "near", "theta": 90.0, "phi": 0.0}
    write_params(**{"far-b": {"scene": "far", "theta": 5, "phi": 5}})
    tree = yaml.safe_load(Path("params.yaml").read_text())
    del tree["viewpoints"]["near-a"]
    Path("params.yaml").write_text(yaml.safe_dump(tree))
    declare(chosen("far", ["far-b"]))
    assert sorted(declared()) == ["far-a", "far-b", "near-b", "study"]


def test_what_is_found_is_copied_beside_what_was(monkeypatch: pytest.MonkeyPatch) -> None:
    (FOUND / "near").mkdir(parents=True)
    (FOUND / "near/near-a.json").write_text("{}")
    (PUBLISHED / "near").mkdir(parents=True)
    (PUBLISHED / "near/study.json").write_text("{}")
    publish("near", ["near-a"])
    assert sorted(file.name for file in (PUBLISHED / "near").iterdir()) == ["near-a.json", "study.json"]


def test_a_stage_that_failed_is_the_command_s_status_and_nothing_is_copied(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[tuple[str, ...]] = []

    def on_this_terminal(*words: str) -> int:
        asked.append(words)
        return 7

    monkeypatch.setattr(ablation, "on_this_terminal", on_this_terminal)
    for name in ("check_parameters", "check_lock"):
        monkeypatch.setattr(ablation, name, lambda *_: None)
    assert main(["near", "study"]) == 7
    assert asked[0][-1] == "ablation/dvc.yaml:ablation@study" and len(asked) == 1
    assert not PUBLISHED.exists()
