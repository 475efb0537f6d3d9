"""`./run ablation SCENE [VIEW …]`: what the judge of a scene reaches without one of its parts."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from pipeline.contract.errors import unknown
from pipeline.contract.viewpoints import Viewpoint, named_viewpoints
from pipeline.contract.yamls import read_yaml
from pipeline.storage.artefacts import writing
from runner.lock import check_lock
from runner.parameters import check_parameters
from runner.schedule import on_this_terminal
from runner.search import report

FILE, LOCK = "ablation/dvc.yaml", Path("ablation/dvc.lock")
VIEWS_FILE = Path("ablation/views.yaml")
HEAD = """\
# The viewpoints that `./run ablation` was given; DVC tries the judge of each without one of its parts.
"""
FOUND, PUBLISHED = Path("ablation/found"), Path("reports/ablations")


def main(argv: Sequence[str]) -> int:
    """Runs the command and returns the exit status."""
    asked = _parser().parse_args(argv)
    check_parameters()
    check_lock()
    check_lock(LOCK)
    views = chosen(asked.scene, asked.views)
    declare(views)
    stages = [f"{FILE}:ablation@{key}" for key in views]
    if status := on_this_terminal("repro", *stages):
        return status
    publish(asked.scene, list(views))
    return report()


def chosen(scene: str, keys: Sequence[str]) -> dict[str, Viewpoint]:
    """The viewpoints of those names, all of the scene where none is named.

    Raises:
        BelvedereError: the scene has no viewpoint, or none of such a name.
    """
    every = named_viewpoints()
    known = {key: view for key, view in every.items() if view.scene == scene}
    if not known:
        raise unknown("scene with a viewpoint", scene, {view.scene for view in every.values()})
    for key in keys:
        if key not in known:
            raise unknown(f"viewpoint of {scene}", key, known)
    return {key: known[key] for key in keys or known}


def declare(views: Mapping[str, Viewpoint]) -> None:
    """Writes the viewpoints, and those that were tried before and still are some, to where DVC reads them."""
    every = named_viewpoints()
    before = read_yaml(VIEWS_FILE)["views"] if VIEWS_FILE.is_file() else {}
    kept = {key: every[key] for key in before if key in every} | dict(views)
    tree = {"views": {key: view.model_dump() for key, view in sorted(kept.items())}}
    text = HEAD + yaml.safe_dump(tree, default_flow_style=None, sort_keys=False, width=110)
    with writing(VIEWS_FILE) as aside:
        aside.write_text(text, encoding="utf-8")


def publish(scene: str, keys: Sequence[str]) -> None:
    """Copies the tables to where the report reads them; those of other viewpoints stay."""
    for key in keys:
        with writing(PUBLISHED / scene / f"{key}.json") as aside:
            shutil.copyfile(FOUND / scene / f"{key}.json", aside)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="./run ablation", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("scene", metavar="SCENE", help="of params.yaml")
    parser.add_argument("views", nargs="*", metavar="VIEW", help="its viewpoints; without any, all")
    return parser
