"""What dvc.yaml repeats stages over, held to the viewpoints and scenes of params.yaml.

DVC repeats a stage over the keys that dvc.yaml lists. A viewpoint that only params.yaml has would never be
computed, and one whose line was taken out of dvc.yaml would go on being ranked from its last result.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import STUDY
from pipeline.contract.yamls import read_yaml

PIPELINE_FILE = Path("dvc.yaml")


def branches(path: Path = PIPELINE_FILE) -> frozenset[str]:
    """The branches: what dvc.yaml repeats stages over by a map (a list of scenes is no map)."""
    return frozenset(key for each in _repeated(path, dict).values() for key in each)


def check_viewpoints(path: Path = PIPELINE_FILE, parameters: Path = params.PARAMS_FILE) -> None:
    """Checks that the stages of branches are repeated over the viewpoints of params.yaml.

    Raises:
        BelvedereError: a viewpoint stands in one of the files only, or under another key.
    """
    named = params.value("viewpoints", path=parameters) or {}
    wanted = {STUDY: "${viewpoint}"} | {key: f"${{viewpoints.{key}}}" for key in named}
    for stage, found in _repeated(path, dict).items():
        for key, place in wanted.items():
            if found.get(key) != place:
                raise BelvedereError(
                    f"{parameters} has the viewpoint {key!r}, but stage {stage!r} of {path} is not repeated "
                    f"over it: add the line `{key}: {place}` to the list of branches there (foreach: "
                    f"&branches), or take the viewpoint out of {parameters}."
                )
        for key in found.keys() - wanted.keys():
            raise BelvedereError(
                f"stage {stage!r} of {path} is repeated over {key!r}, but {parameters} has no viewpoint of "
                f"that name: add a line `{key}:` to its viewpoints, or take the line out of {path}."
            )


def check_scenes(path: Path = PIPELINE_FILE, parameters: Path = params.PARAMS_FILE) -> None:
    """Checks that the stages of scenes are repeated over the scenes of params.yaml.

    Raises:
        BelvedereError: a scene stands in one of the files only.
    """
    wanted = set(params.value("scenes", path=parameters))
    for stage, found in _repeated(path, list).items():
        for scene in sorted(wanted ^ set(found)):
            here, there = (parameters, path) if scene in wanted else (path, parameters)
            raise BelvedereError(
                f"{here} has the scene {scene!r}, but {there} has not (stage {stage!r} is repeated over "
                f"{', '.join(map(str, found))}): add it to {there}, or take it out of {here}."
            )


def _repeated(path: Path, kind: type) -> dict[str, Any]:
    """By stage, what it is repeated over, of the stages that are repeated over a ``kind``."""
    try:
        tree = read_yaml(path)
    except FileNotFoundError:
        raise BelvedereError(f"{path} is missing; run this from the repository's root.") from None
    stages: Mapping[str, Any] = tree["stages"]
    return {name: s["foreach"] for name, s in stages.items() if isinstance(s.get("foreach"), kind)}
