"""A repeat is made again where code changed that its stage imports, and nowhere else."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from pipeline.contract import source

STAGES = ("rollouts", "frames", "vae", "latents", "mdnrnn", "controller", "evaluation", "dqn")


@pytest.fixture
def copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The root of a copy of the pipeline's source, which may be changed."""
    code = shutil.ignore_patterns("__pycache__")
    shutil.copytree(source.ROOT / "pipeline", tmp_path / "pipeline", ignore=code)
    monkeypatch.setattr(source, "ROOT", tmp_path)
    forget()
    yield tmp_path
    forget()


def forget() -> None:
    for cached in (source.tree, source.imported_names, source.modules_behind):
        cached.cache_clear()


@pytest.mark.parametrize(
    ("changed", "those"),
    [
        ("learning/training.py", {"vae", "mdnrnn"}),
        ("sim/tasks/base.py", {"rollouts", "frames", "controller", "evaluation", "dqn"}),
        ("rendering/raytracer.py", {"frames", "controller", "evaluation", "dqn"}),
        ("latents.py", {"latents"}),
        ("reporting/page.py", set()),
    ],
)
def test_a_changed_file_counts_for_the_stages_that_import_it(
    copy: Path, changed: str, those: set[str]
) -> None:
    before = {stage: source.code_digest(stage) for stage in STAGES}
    with (copy / "pipeline" / changed).open("a", encoding="utf-8") as file:
        file.write("\n# changed\n")
    assert {stage for stage in STAGES if source.code_digest(stage) != before[stage]} == those


def test_where_the_tree_lies_does_not_count(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    moved = source.code_digest("vae")
    monkeypatch.undo()
    forget()
    assert source.code_digest("vae") == moved
