"""DVC with the faster parser reads and writes what DVC alone does."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import pytest
from dvc.utils.serialize import _yaml

from pipeline.contract.yamls import parse
from tests.support import ROOT, Clone, ran

WORDS = ["no", "on", "y", "null", "~", "0o17", "0x1f", "030", "1_000", "12:30"]
WORDS += ["1e5", "1e-05", "1.", ".5", "-.inf", "1_0.5", "+7"]
# DVC's own parser is ruamel's: does it read dvc.lock when DVC loads a stage?
COLLECT = """
from ruamel.yaml import YAML
from dvc.repo import Repo
from runner.dvc import read_faster
slow, read = YAML.load, []
YAML.load = lambda self, text: (read.append(text), slow(self, text))[1]
FASTER and read_faster()
with Repo() as repo:
    repo.stage.collect("vae@study")
print(open("dvc.lock").read() in read)
"""
HALF_WRITTEN = """
from runner import dvc
from dvc.utils.serialize import _yaml
def interrupted(*_):
    raise RuntimeError("while it was written")
dvc.updated = interrupted
dvc.write_faster()
with _yaml.modify_yaml("dvc.lock") as data:
    data["stages"].clear()
"""
VALUES = [None, True, -3, 1e-05, 1e300, 0.1, -math.inf, "", "a b", "ä", "- x", "a: b", "#", "it's", *WORDS]


@pytest.mark.parametrize("name", ["dvc.yaml", "params.yaml", "data/allocation.yaml", "dvc.lock"])
def test_our_files_are_read_alike(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    slow = _yaml.parse_yaml(text, name)
    assert parse(text) == slow and slow
    assert repr(parse(text)) == repr(slow)  # types, too: 1 and 1.0 are equal


def test_what_dvc_writes_comes_back() -> None:
    written = {str(index): value for index, value in enumerate(VALUES)}
    assert repr(parse(_yaml.dumps_yaml(written))) == repr(written)


@pytest.mark.parametrize("word", WORDS)
def test_plain_words_are_read_alike(word: str) -> None:
    assert repr(parse(f"a: {word}")) == repr(_yaml.parse_yaml(f"a: {word}", "params.yaml"))


@pytest.mark.parametrize("faster", [True, False])
def test_the_lock_is_never_read_by_the_slow_parser(clone: Clone, faster: bool) -> None:
    shutil.copyfile(ROOT / "dvc.lock", clone.root / "dvc.lock")
    code = COLLECT.replace("FASTER", str(faster))
    assert clone.run("python", "-c", code).stdout.split()[-1] == str(not faster)


def test_a_stage_leaves_the_same_lock(clone: Clone) -> None:
    params = clone.root / "params.yaml"
    params.write_text(params.read_text(encoding="utf-8").replace("budget: quick", "budget: tiny"))
    locks = []
    for command in (["dvc"], ["python", "-m", "runner.dvc"]):
        for stage in ("rollouts@panda_1dof", "rollouts@panda_2dof"):  # of two at once DVC chooses the order
            told = clone.run(*command, "repro", "--no-run-cache", stage, timeout_s=600)
            assert stage in ran(told.stdout)
        locks.append((clone.root / "dvc.lock").read_bytes())
        (clone.root / "dvc.lock").unlink()
    assert locks[0] == locks[1]


def test_a_lock_is_never_there_half_written(clone: Clone) -> None:
    shutil.copyfile(ROOT / "dvc.lock", clone.root / "dvc.lock")
    told = clone.run("python", "-c", HALF_WRITTEN, status=1).stderr
    assert told.rstrip().endswith("RuntimeError: while it was written")
    assert (clone.root / "dvc.lock").read_bytes() == (ROOT / "dvc.lock").read_bytes()
    assert not list(clone.root.glob("*.part")) and not list(clone.root.glob(".*.part"))


def test_a_broken_file_is_told_in_dvcs_words(clone: Clone) -> None:
    Path(clone.root / "params.yaml").write_text("a: [", encoding="utf-8")
    told = clone.run("python", "-m", "runner.dvc", "repro", status=255).stderr
    assert "params.yaml" in told and "Traceback" not in told
