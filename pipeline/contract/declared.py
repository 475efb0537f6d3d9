"""The branches that dvc.yaml lists, held to the viewpoints of params.yaml.

Scenes need no list (`foreach: ${scenes}`). Branches do: the study's viewpoint stands by itself, so that
`dvc exp run -S viewpoint.phi=30` changes it, and DVC cannot join it to the map `viewpoints`. A viewpoint
that only params.yaml has would never be computed, and one whose line was taken out of dvc.yaml would go on
being ranked from its last result.
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
    """The branches: what dvc.yaml repeats stages over by a map."""
    return frozenset(key for each in _branch_stages(path).values() for key in each)


def check_viewpoints(path: Path = PIPELINE_FILE, parameters: Path = params.PARAMS_FILE) -> None:
    """Checks that the stages of branches are repeated over the viewpoints of params.yaml.

    Raises:
        BelvedereError: a viewpoint stands in one of the files only, or under another key.
    """
    named = params.value("viewpoints", path=parameters) or {}
    wanted = {STUDY: "${viewpoint}"} | {key: f"${{viewpoints.{key}}}" for key in named}
    for stage, found in _branch_stages(path).items():
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


def _branch_stages(path: Path) -> dict[str, dict[str, str]]:
    """By stage that is repeated over branches, its branches and where their values stand."""
    try:
        tree = read_yaml(path)
    except FileNotFoundError:
        raise BelvedereError(f"{path} is missing; run this from the repository's root.") from None
    stages: Mapping[str, Any] = tree["stages"]
    return {name: s["foreach"] for name, s in stages.items() if isinstance(s.get("foreach"), dict)}
