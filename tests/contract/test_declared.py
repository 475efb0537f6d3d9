"""params.yaml and dvc.yaml name the same viewpoints and scenes, or one sentence says which they do not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.contract.declared import branches, check_viewpoints
from pipeline.contract.errors import BelvedereError
from tests.support import ROOT, Clone

Tree = dict[str, Any]
ADDED = {"scene": "fetch_reach", "theta": 20, "phi": 30}
LINE = "${viewpoints.fetch_reach-g}"


@pytest.fixture
def change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Changes copies of the repository's two files, in the working directory."""
    monkeypatch.chdir(tmp_path)
    trees = {name: yaml.safe_load((ROOT / name).read_text()) for name in ("params.yaml", "dvc.yaml")}

    def write(*changes: Callable[[Tree, Tree], object]) -> None:
        for each in changes:
            each(trees["params.yaml"], trees["dvc.yaml"]["stages"])
        for name, tree in trees.items():
            Path(name).write_text(yaml.safe_dump(tree, sort_keys=False))

    return write


def in_all(key: str, place: str) -> Callable[[Tree, Tree], object]:
    """Adds a line to the map that the stages of branches share (YAML's alias makes it one object)."""
    return lambda _, stages: stages["frames"]["foreach"].update({key: place})


def test_the_repositorys_own_files_agree(change: Callable[..., None]) -> None:
    change()
    check_viewpoints()
    change(lambda params, _: params["viewpoints"].update({"fetch_reach-g": ADDED}))
    change(in_all("fetch_reach-g", LINE))
    check_viewpoints()
    assert "fetch_reach-g" in branches()


DISAGREEING: dict[str, tuple[Callable[[Tree, Tree], object], str]] = {
    "a viewpoint is in params.yaml only": (
        lambda params, _: params["viewpoints"].update({"fetch_reach-g": ADDED}),
        r"params\.yaml has the viewpoint 'fetch_reach-g', but stage 'frames' of dvc\.yaml is not repeated "
        r"over it: add the line `fetch_reach-g: \$\{viewpoints\.fetch_reach-g\}`",
    ),
    "a viewpoint is in dvc.yaml only": (
        in_all("fetch_reach-g", LINE),
        r"dvc\.yaml is repeated over 'fetch_reach-g', but params\.yaml has no viewpoint of that name",
    ),
    "one was taken out of dvc.yaml only": (
        lambda _, stages: stages["frames"]["foreach"].pop("fetch_reach-c"),
        r"viewpoint 'fetch_reach-c', but stage 'frames'",
    ),
    "one stage has a list of its own": (
        lambda _, stages: stages["dqn"].update(foreach={"study": "${viewpoint}"}),
        r"viewpoint 'panda_1dof-a', but stage 'dqn'",
    ),
    "one has the other's angles": (
        lambda _, stages: stages["frames"]["foreach"].update(
            {"fetch_reach-c": "${viewpoints.fetch_reach-a}"}
        ),
        r"add the line `fetch_reach-c: \$\{viewpoints\.fetch_reach-c\}`",
    ),
}


@pytest.mark.parametrize("case", DISAGREEING)
def test_where_the_files_disagree_a_sentence_names_both(change: Callable[..., None], case: str) -> None:
    damage, message = DISAGREEING[case]
    change(damage)
    with pytest.raises(BelvedereError, match=message):
        check_viewpoints()


def test_the_front_door_says_so_before_anything_runs(clone: Clone) -> None:
    clone.lend_environment()
    with_one_line(
        clone, "params.yaml", "viewpoints:", "  fetch_reach-g: {scene: fetch_reach, theta: 20, phi: 30}"
    )
    told = clone.run("./run", status=1)
    assert told.stdout == "" and told.stderr.startswith(
        "error: params.yaml has the viewpoint 'fetch_reach-g'"
    )
    assert len(told.stderr.splitlines()) == 1
    assert clone.run("git", "status", "--porcelain").stdout == " M params.yaml\n"


def test_a_viewpoint_added_as_the_docs_say_passes_the_tests(clone: Clone) -> None:
    with_one_line(
        clone, "params.yaml", "viewpoints:", "  fetch_reach-g: {scene: fetch_reach, theta: 20, phi: 30}"
    )
    with_one_line(clone, "dvc.yaml", "      study: ${viewpoint}", f"      fetch_reach-g: {LINE}")
    clone.run("python", "-c", "from runner.race import allocate; allocate()")  # as ./run begins
    clone.run("python", "-m", "pytest", "-q", "tests/test_dvc_yaml.py", timeout_s=600)
    stages = clone.run("dvc", "stage", "list", "--name-only").stdout.split()
    added = {stage for stage in stages if stage.endswith("@fetch_reach-g")}
    assert added == {stage.replace("-a", "-g") for stage in stages if stage.endswith("@fetch_reach-a")}
    assert "dqn@fetch_reach-g" in added


def with_one_line(clone: Clone, name: str, before: str, line: str) -> None:
    """Puts ``line`` after the one line ``before`` of a file of the clone."""
    path = clone.root / name
    lines = path.read_text(encoding="utf-8").splitlines()
    (place,) = [number for number, found in enumerate(lines) if found == before]
    lines.insert(place + 1, line)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
