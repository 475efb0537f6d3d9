"""`python -m pipeline.reporting.gather`: the viewpoints that experiments tried, into a table for the page."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import dvc.api
import polars as pl
import yaml

from pipeline.contract import params
from pipeline.contract.artefacts import read_json, writing
from pipeline.contract.stage import entry
from pipeline.reporting.tried import COLUMNS

ANCHORS, BRANCHES = Path("reports/anchors"), Path("reports/branches")
_VIEWPOINT = "viewpoint"


def main(*, out: Path) -> None:
    """Writes one row per repeat of each experiment that differs from the workspace in its viewpoint only.

    Of experiments with the same viewpoint one is taken: their trainings are the same.
    """
    rows: list[dict[str, Any]] = []
    taken: list[Any] = []
    for name, revision in experiments():
        tree = yaml.safe_load(dvc.api.read(params.PARAMS_FILE.as_posix(), rev=revision))
        other = differs(tree)
        if other:
            print(f"left out: {name} has another {other} in {params.PARAMS_FILE}", file=sys.stderr)
            continue
        if tree[_VIEWPOINT] in taken:
            print(f"left out: {name} has the viewpoint of another experiment", file=sys.stderr)
            continue
        found = list(_rows(name, revision, tree[_VIEWPOINT]))
        if found:  # one that was not evaluated stands in nobody's way
            taken.append(tree[_VIEWPOINT])
            rows += found
    with writing(out) as aside:
        pl.DataFrame(rows, schema=COLUMNS).write_csv(aside)
    print(f"{len({row['experiment'] for row in rows})} experiment(s) gathered; `dvc repro report` shows them")


def experiments() -> Iterator[tuple[str, str]]:
    """Name and revision of each finished experiment that began from the current commit."""
    for row in dvc.api.exp_show():
        if row.get("Experiment"):
            yield str(row["Experiment"]), str(row["rev"])


def differs(tree: Mapping[str, Any]) -> str | None:
    """The first section, but for the viewpoint, in which parameters differ from the workspace's."""
    here = yaml.safe_load(params.PARAMS_FILE.read_text(encoding="utf-8"))
    names = [name for name in {**here, **tree} if name != _VIEWPOINT]
    return next((name for name in names if here.get(name) != tree.get(name)), None)


def _rows(name: str, revision: str, view: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    path = BRANCHES / view["scene"] / "study" / "evaluation.json"
    try:
        found = json.loads(dvc.api.read(path.as_posix(), rev=revision))
    except (FileNotFoundError, json.JSONDecodeError):
        print(f"left out: {name} has no {path}", file=sys.stderr)
        return
    anchors = read_json(ANCHORS / f"{view['scene']}.json", f"anchors@{view['scene']}")
    blind, expert = float(anchors["blind_mean"]), float(anchors["expert_mean"])  # one unit for all repeats
    for own in found["repeats"]:
        yield {
            "experiment": name,
            "scene": found["scene"],
            "theta_deg": found["theta_deg"],
            "phi_deg": found["phi_deg"],
            "budget": params.value("budget"),
            "repeat": own["repeat"],
            "return": own["return"],
            "score": (own["return"] - blind) / (expert - blind),
        }


if __name__ == "__main__":
    entry(main)
