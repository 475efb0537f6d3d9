"""Short sessions of the scripted operator on real stations, for the tests."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pipeline.contract import params
from pipeline.contract.yamls import read_yaml
from pipeline.scripted.params import OperatorParams
from pipeline.station.operate import Report, operate
from pipeline.station.params import station_params
from pipeline.station.started import Started
from tests.support import ROOT

SMALL: dict[str, Any] = {
    "tasks": ["panda_1dof"],
    "views_per_task": 2,
    "trials": 2,
    "picture": [160, 128],
    "renderer": "ray tracer",
    "practice_s": [0, 60],
    "trial_limit_s": 20,
}
FAST: dict[str, Any] = {
    "gain_per_s": 4.0,
    "look_s": 0.04,
    "reaction_s": 0.04,
    "dwell_s": 0.08,
    "speed_m_s": 0.25,
}


def small_station(folder: Path, **changed: Any) -> Path:
    """A folder whose params.yaml has a session of a few short trials; ``changed`` is of section station."""
    tree = read_yaml(ROOT / params.PARAMS_FILE)
    tree["station"] |= SMALL | changed
    tree["operator"] |= FAST
    folder.mkdir(parents=True, exist_ok=True)
    (folder / params.PARAMS_FILE).write_text(yaml.safe_dump(tree, allow_unicode=True), encoding="utf-8")
    return folder


def start(folder: Path, *arguments: str) -> Started:
    """A station of the scripted operator in ``folder``."""
    return Started(
        [*arguments, "--operator", "scripted", "--study", "study", "--port", "0"], folder, quiet=True
    )


def drive(folder: Path, link: str, seed: int = 0) -> Report:
    """Goes through the session behind a link."""
    path = folder / params.PARAMS_FILE
    operator = params.section(OperatorParams, "operator", path=path)
    return asyncio.run(operate(link, operator, station_params(path), np.random.default_rng(seed)))


def code_of(folder: Path) -> str:
    """The code of the only participant."""
    (found,) = (folder / "study").glob("sub-*")
    return found.name.removeprefix("sub-")


def file_of(folder: Path, ending: str) -> Path:
    """The only participant's file of this ending, such as ``trials.jsonl``."""
    code = code_of(folder)
    return folder / "study" / f"sub-{code}" / "beh" / f"sub-{code}_ses-01_{ending}"


def lines_of(folder: Path, ending: str) -> list[dict[str, Any]]:
    """The lines of such a file; none where there is none yet."""
    path = file_of(folder, ending)
    return (
        [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []
    )
