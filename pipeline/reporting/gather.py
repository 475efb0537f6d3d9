"""`python -m pipeline.reporting.gather`: the viewpoints that experiments tried, into a table for the page."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import dvc.api
import polars as pl

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.yamls import parse, read_yaml
from pipeline.reporting.experiments import Experiment, experiments, other_code, stale
from pipeline.reporting.tried import COLUMNS, parameters_digest
from pipeline.storage.artefacts import read_json, writing
from pipeline.storage.stage import entry

ANCHORS, BRANCHES = Path("reports/anchors"), Path("reports/branches")
_VIEWPOINT, _STAGE = "viewpoint", "evaluation@study"


class _LeftOut(Exception):
    """Why an experiment is not gathered."""


def main(*, out: Path) -> None:
    """Writes one row per repeat of each experiment that differs from the workspace in its viewpoint only.

    Taken are experiments that ended with success, with the results of their own revision's viewpoint,
    parameters and code. Of those with the same viewpoint the one with the most repeats is taken: the
    trainings that they share are the same.
    """
    found: dict[str, list[dict[str, Any]]] = {}
    for experiment in sorted(experiments(), key=lambda each: each.name):
        try:
            found[experiment.name] = _rows(experiment)
        except _LeftOut as reason:
            print(f"left out: {experiment.name} {reason}", file=sys.stderr)
    taken: dict[tuple[Any, ...], str] = {}
    for name in sorted(found, key=lambda name: -len(found[name])):
        place = tuple(found[name][0][column] for column in ("scene", "theta_deg", "phi_deg"))
        if place in taken:
            print(f"left out: {name} has the viewpoint of {taken[place]}", file=sys.stderr)
        taken.setdefault(place, name)
    rows = [row for name in taken.values() for row in found[name]]
    with writing(out) as aside:
        pl.DataFrame(rows, schema=COLUMNS).write_csv(aside)
    print(f"{len(taken)} experiment(s) gathered; `dvc repro report` shows them")


def differs(tree: Mapping[str, Any]) -> str | None:
    """The first section, but for the viewpoint, in which parameters differ from the workspace's."""
    here = read_yaml(params.PARAMS_FILE)
    names = [name for name in {**here, **tree} if name != _VIEWPOINT]
    return next((name for name in names if here.get(name) != tree.get(name)), None)


def _rows(experiment: Experiment) -> list[dict[str, Any]]:
    """The rows of one experiment.

    Raises:
        _LeftOut: its results are not of its own viewpoint, or not of the workspace's parameters and code.
    """
    if experiment.unfinished:
        raise _LeftOut(f"is {experiment.unfinished}, so that it has no results of its own")
    revision = experiment.revision
    tree = parse(dvc.api.read(params.PARAMS_FILE.as_posix(), rev=revision))
    if other := differs(tree):
        raise _LeftOut(f"has another {other} in {params.PARAMS_FILE}")
    view = tree[_VIEWPOINT]
    path = BRANCHES / view["scene"] / "study" / "evaluation.json"
    content = _evaluation(path, view, revision)
    if stage := stale(_STAGE, revision):
        raise _LeftOut(f"has not run {stage} with the parameters and code of its own revision")
    if code := other_code(_STAGE, revision):
        raise _LeftOut(f"was made by another {code[0]} than there is here")
    blind, expert = _anchors(view["scene"])
    return [
        {
            "experiment": experiment.name,
            "scene": content["scene"],
            "theta_deg": content["theta_deg"],
            "phi_deg": content["phi_deg"],
            "budget": params.budget(),
            "parameters": parameters_digest(view["scene"]),
            "repeat": own["repeat"],
            "return": own["return"],
            "score": (own["return"] - blind) / (expert - blind),
        }
        for own in content["repeats"]
    ]


def _evaluation(path: Path, view: Mapping[str, Any], revision: str) -> dict[str, Any]:
    """What lies at ``path`` in the revision, if it is of the viewpoint."""
    try:
        content = json.loads(dvc.api.read(path.as_posix(), rev=revision))
    except (FileNotFoundError, json.JSONDecodeError):
        raise _LeftOut(f"has no {path}") from None
    found = tuple(content.get(name) for name in ("scene", "theta_deg", "phi_deg"))
    meant = (view["scene"], view["theta"], view["phi"])
    if found != meant:
        raise _LeftOut(f"has a {path} of {found}, though its viewpoint is {meant}")
    if not content.get("repeats"):
        raise _LeftOut(f"has no repeat in {path}")
    return dict(content)


def _anchors(scene: str) -> tuple[float, float]:
    """Blind and expert, m: one unit for all repeats.

    Raises:
        BelvedereError: they are missing, or of other parameters or code than the workspace's.
    """
    path, made_by = ANCHORS / f"{scene}.json", f"anchors@{scene}"
    anchors = read_json(path, made_by)
    if stale(made_by):
        raise BelvedereError(
            f"{path} is of other parameters or code than there are here, so that scores would have another "
            f"unit than the page's; `dvc repro {made_by}` makes it again."
        )
    return float(anchors["blind_mean"]), float(anchors["expert_mean"])


if __name__ == "__main__":
    entry(main)
