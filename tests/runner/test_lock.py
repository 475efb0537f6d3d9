"""dvc.lock with some stages changed, against DVC's own text of the whole."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from dvc.utils.serialize import _yaml

from pipeline.contract.errors import BelvedereError
from runner.lock import check_lock, updated
from tests.support import ROOT, Clone

Tree = dict[str, Any]
LOCK = (ROOT / "dvc.lock").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def before() -> Tree:
    tree = _yaml.parse_yaml(LOCK, "dvc.lock")
    stages = dict(list(tree["stages"].items())[:12])
    return {"schema": tree["schema"], "stages": stages}


def _first(tree: Tree) -> Tree:
    stage: Tree = next(iter(tree["stages"].values()))
    return stage


def change(tree: Tree) -> None:
    _first(tree)["cmd"] = "python -m " + "word " * 40 + "end"


def retype(tree: Tree) -> None:
    _first(tree)["outs"][0]["size"] = float(_first(tree)["outs"][0]["size"])


def add(tree: Tree) -> None:
    tree["stages"]["new@one"] = {"cmd": "a: b", "params": {"x": [1, None, {"y": 1e-05}]}}


def remove(tree: Tree) -> None:
    del tree["stages"][list(tree["stages"])[3]]


def move(tree: Tree) -> None:
    name = next(iter(tree["stages"]))
    tree["stages"][name] = tree["stages"].pop(name)


def empty(tree: Tree) -> None:
    tree["stages"].clear()


def extend(tree: Tree) -> None:
    tree["datasets"] = [{"name": "a"}]


@pytest.mark.parametrize("edit", [lambda tree: None, change, retype, add, remove, move, empty, extend])
def test_the_text_is_dvcs(before: Tree, edit: Callable[[Tree], None]) -> None:
    after = copy.deepcopy(before)
    edit(after)
    text = _yaml.dumps_yaml(before)
    assert updated(text, before, after, _yaml.dumps_yaml) == _yaml.dumps_yaml(after)


def test_only_what_changed_is_written(before: Tree) -> None:
    after, written = copy.deepcopy(before), []
    change(after)
    updated(_yaml.dumps_yaml(before), before, after, lambda tree: written.append(tree) or "stages:\n")  # type: ignore[func-returns-value]
    assert written == [{"stages": dict([next(iter(after["stages"].items()))])}]


def test_a_text_of_another_form_is_written_whole(before: Tree) -> None:
    text = "# mine\n" + _yaml.dumps_yaml(before).replace("stages:\n", "stages:\n  # a note\n")
    assert updated(text, before, before, _yaml.dumps_yaml) == _yaml.dumps_yaml(before)


def test_what_dvc_cannot_read_is_told_with_the_remedy(tmp_path: Path) -> None:
    """Cut anywhere, as by a kill while DVC writes: refused if, and only if, DVC refuses it."""
    from dvc.schema import COMPILED_LOCKFILE_SCHEMA
    from voluptuous import Invalid

    path, refused = tmp_path / "dvc.lock", 0
    check_lock(path)  # there is none before the first stage
    cuts = [LOCK[:at] for at in range(0, 4000, 97)]
    for text in [*cuts, "stages: [", "- a", "schema: '2.0'\nstages: 3\n"]:
        path.write_text(text, encoding="utf-8")
        try:
            COMPILED_LOCKFILE_SCHEMA(_yaml.parse_yaml(text, path))
            fits = True
        except (Invalid, _yaml.YAMLFileCorruptedError):
            fits = False
        try:
            check_lock(path)
            assert fits, text[-200:]
        except BelvedereError as error:
            refused += 1
            assert not fits and "git checkout" in str(error)
    assert refused > 5


@pytest.mark.parametrize("command", [["runner"], ["runner.dvc", "repro"]])
def test_a_damaged_lock_is_told_at_the_door(clone: Clone, command: list[str]) -> None:
    (clone.root / "dvc.lock").write_text(LOCK[: len(LOCK) // 2].rpartition(":")[0], encoding="utf-8")
    said = clone.run("python", "-m", *command, status=None).stderr
    assert "git checkout dvc.lock" in said and "Traceback" not in said
