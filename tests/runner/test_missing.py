"""`--allow-missing` in a clone with results but no data, on a small repository of four stages in a row."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import yaml

from tests.support import ROOT, Clone, ran

# Writes what it was given, and what its inputs hold, into each of its outputs.
STAGE = """
import pathlib, sys, yaml
name, *inputs = sys.argv[1:]
content = yaml.safe_load(open("params.yaml"))[name] + "".join(pathlib.Path(i).read_text() for i in inputs)
for out in (pathlib.Path("data") / name, pathlib.Path("reports") / name):
    out.parent.mkdir(exist_ok=True)
    out.write_text(content)
"""
DVC = """
import sys
from dvc.cli import main
from runner.missing import make_missing, refuse_missing_in_queue
make_missing()
refuse_missing_in_queue()
sys.exit(main(sys.argv[1:]))
"""
READS: dict[str, list[str]] = {"a": [], "b": ["data/a"], "c": ["data/b"], "d": ["data/b", "data/c"]}


def stage(name: str) -> dict[str, object]:
    inputs = READS[name]
    return {
        "cmd": " ".join(["python stage.py", name, *inputs]),
        "deps": inputs,
        "params": [name],
        "outs": [f"data/{name}"],
        "metrics": [{f"reports/{name}": {"cache": False}}],
    }


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Clone:
    """A repository in which all stages ran and the results are committed."""
    made = Clone(tmp_path_factory.mktemp("done") / "a study")
    made.root.mkdir()
    (made.root / "stage.py").write_text(STAGE)
    (made.root / "dvc.yaml").write_text(yaml.safe_dump({"stages": {name: stage(name) for name in READS}}))
    (made.root / "params.yaml").write_text(yaml.safe_dump({name: f"{name}1" for name in READS}))
    (made.root / ".gitignore").write_text("/data\n")
    made.begin()
    return made


@pytest.fixture
def fresh(done: Clone, tmp_path: Path) -> Clone:
    """A clone of it, which has results but no data."""
    done.run("git", "clone", "--quiet", done.root, tmp_path / "fresh clone")
    return Clone(tmp_path / "fresh clone")


def dvc(clone: Clone, *words: str, status: int = 0) -> str:
    """What DVC says on both streams; as ./run starts it, but for the check of params.yaml."""
    found = clone.run("python", "-c", DVC, *words, status=status, PYTHONPATH=str(ROOT))
    return found.stdout + found.stderr


@pytest.mark.parametrize(("changed", "where"), [("c", ()), ("d", ("--temp",))])
def test_what_a_changed_stage_reads_is_made_and_comes_out_as_without_the_option(
    done: Clone, fresh: Clone, tmp_path: Path, changed: str, where: tuple[str, ...]
) -> None:
    words = ("exp", "run", *where, "--name", "it", "-S", f"{changed}=other")
    done.run("git", "clone", "--quiet", done.root, tmp_path / "another")
    all_anew = Clone(tmp_path / "another")
    dvc(all_anew, *words)
    assert ran(dvc(fresh, *words, "--allow-missing")) == set(READS)
    trees = ("git", "for-each-ref", "--format=%(tree) %(refname:lstrip=-1)", "refs/exps")
    kept = [each.run(*trees).stdout.splitlines() for each in (all_anew, fresh)]
    (tree,) = {
        line for line in kept[0] if line.endswith(" it")
    }  # git's hash of params.yaml, dvc.lock, results
    assert tree in kept[1]


def test_only_what_is_absent_is_made(done: Clone, fresh: Clone) -> None:
    (fresh.root / "data").mkdir()
    shutil.copyfile(done.root / "data" / "b", fresh.root / "data" / "b")
    params = fresh.root / "params.yaml"
    params.write_text(params.read_text().replace("c: c1", "c: other"))
    assert ran(dvc(fresh, "repro", "--allow-missing", "c")) == {"c"}
    assert (fresh.root / "data/c").read_text() == "otherb1a1"
    assert not (fresh.root / "data/a").exists()


def test_where_nothing_changed_nothing_is_made(fresh: Clone) -> None:
    assert ran(dvc(fresh, "repro", "--allow-missing")) == set()
    assert not (fresh.root / "data").exists()


def test_a_dry_run_names_the_stages_and_leaves_all_as_it_was(fresh: Clone) -> None:
    told = dvc(fresh, "exp", "run", "--dry", "--allow-missing", "-S", "c=other", "c")
    assert ran(told) == {"a", "b", "c"}
    assert untouched(fresh)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("exp", "run", "--queue", "-S", "c=other"), "--allow-missing does not go with --queue"),
        (("repro", "--single-item", "--force", "c"), "stage 'c' needs what 'b' makes, which is absent here"),
    ],
)
def test_what_cannot_be_made_is_told_before_anything_changes(
    fresh: Clone, words: tuple[str, ...], message: str
) -> None:
    told = dvc(fresh, *words, "--allow-missing", status=255)
    assert message in told and "Traceback" not in told
    assert untouched(fresh)


def untouched(clone: Clone) -> bool:
    clean = clone.run("git", "status", "--porcelain").stdout == ""
    return clean and not (clone.root / "data").exists()
