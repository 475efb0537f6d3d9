"""A scene's results as the stages `evaluation` and `anchors` left them, checked and put in a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract import params
from pipeline.contract.artefacts import read_json
from pipeline.contract.errors import BelvedereError, unknown
from pipeline.contract.params import Section

# Threads, processor and Python leave results alone (batches are bit-identical at any thread count);
# these do not. The anchors have no network and no pictures, so only the physics has to agree.
COMPARED = ("device", "gpu", "dtype", "torch", "mujoco", "mujoco_warp")
COMPARED_WITH_ANCHORS = ("mujoco",)
CHOSEN = ("device", "dtype")  # by the environment variables of these names
ANCHORS = ("no_op", "blind", "expert")

Table = dict[int, tuple[float, ...]]  # numbers by repeat


class Branch(Section):
    """A viewpoint as params.yaml names it; ``theta`` and ``phi`` in degrees."""

    scene: str
    theta: float
    phi: float


@dataclass(frozen=True)
class Results:
    """A scene's results.

    Attributes:
        branches: the viewpoints ranked, by key; each viewpoint once.
        duplicates: for each key, the other branches with the same viewpoint.
        returns: (view, repeat) mean return of an episode, in the order of ``branches``.
        anchors: ``no_op``, ``blind`` and ``expert``, each (repeat,) mean return of an episode.
        made_with: how each branch's numbers were made, by key.
    """

    branches: dict[str, Branch]
    duplicates: dict[str, list[str]]
    returns: np.ndarray
    anchors: dict[str, np.ndarray]
    made_with: dict[str, dict[str, Any]]

    @property
    def scores(self) -> np.ndarray:
        """(view, repeat) share of the way from blind (0) to expert (1), within each repeat."""
        blind, expert = self.anchors["blind"], self.anchors["expert"]
        return (self.returns - blind) / (expert - blind)


def scene_branches(
    scene: str, path: Path = params.PARAMS_FILE
) -> tuple[dict[str, Branch], dict[str, list[str]]]:
    """The scene's branches in params.yaml, and for each the later ones with the same viewpoint.

    Candidates (``viewpoints``) come before ``study`` (``viewpoint``), so a study of a candidate's
    viewpoint is that candidate's duplicate.

    Raises:
        BelvedereError: no branch is of this scene, or one is not valid.
    """
    places = {key: ("viewpoints", key) for key in params.value("viewpoints", path=path) or ()}
    named = {key: params.section(Branch, *place, path=path) for key, place in places.items()}
    named["study"] = params.section(Branch, "viewpoint", path=path)
    kept: dict[Branch, str] = {}
    duplicates: dict[str, list[str]] = {}
    for key, branch in named.items():
        if branch.scene == scene:
            first = kept.setdefault(branch, key)
            duplicates.setdefault(first, []).extend([key] if key != first else [])
    if not kept:
        raise unknown("scene with a viewpoint", scene, {branch.scene for branch in named.values()})
    return {key: branch for branch, key in kept.items()}, duplicates


def read_results(
    scene: str, folder: Path, anchors: Path, mix: bool = False, path: Path = params.PARAMS_FILE
) -> Results:
    """Reads ``{folder}/{key}/evaluation.json`` of the scene's branches, and the anchors' file.

    Args:
        scene: the scene's name.
        folder: holds one folder per branch; those that params.yaml does not name are passed over.
        anchors: the scene's anchors.
        mix: accept branches that were made differently.
        path: the parameter file.

    Raises:
        BelvedereError: a file is missing or foreign, repeats differ, an expert is not above blind,
            or the branches were made differently.
    """
    branches, duplicates = scene_branches(scene, path)
    read = {key: _read_branch(folder / key / "evaluation.json", key, branches[key]) for key in branches}
    levels, anchors_with = _read_anchors(anchors, scene)
    rows = {key: table for key, (table, _) in read.items()}
    made_with = {key: made for key, (_, made) in read.items()}
    _check_repeats({**rows, "anchors": levels})
    if not mix:
        _check_made_alike(scene, made_with, COMPARED)
        _check_made_alike(scene, {**made_with, "anchors": anchors_with}, COMPARED_WITH_ANCHORS)
    repeats = sorted(levels)
    returns = np.array([[rows[key][r][0] for r in repeats] for key in branches])
    by_anchor = zip(ANCHORS, np.array([levels[r] for r in repeats]).T, strict=True)
    return Results(branches, duplicates, returns, dict(by_anchor), made_with)


def _read_branch(file: Path, key: str, branch: Branch) -> tuple[Table, dict[str, Any]]:
    made_by = f"evaluation@{key}"
    content = read_json(file, made_by)
    found = tuple(content.get(name) for name in ("scene", "theta_deg", "phi_deg"))
    meant = (branch.scene, branch.theta, branch.phi)
    if found != meant:
        raise _foreign(file, f"it is of {found}, but params.yaml says {meant}", made_by)
    return _by_repeat(file, content, ("return",), made_by), _made_with(file, content, made_by)


def _read_anchors(file: Path, scene: str) -> tuple[Table, dict[str, Any]]:
    made_by = f"anchors@{scene}"
    content = read_json(file, made_by)
    if content.get("scene") != scene:
        raise _foreign(file, f"it is of scene {content.get('scene')!r}, not {scene!r}", made_by)
    levels = _by_repeat(file, content, ANCHORS, made_by)
    _check_expert(file, levels)
    return levels, _made_with(file, content, made_by)


def _by_repeat(file: Path, content: Mapping[str, Any], names: tuple[str, ...], made_by: str) -> Table:
    try:
        table = {int(r["repeat"]): tuple(float(r[name]) for name in names) for r in content["repeats"]}
        count = len(content["repeats"])
    except (KeyError, TypeError, ValueError) as error:
        raise _foreign(file, f"its repeats lack a number ({error})", made_by) from None
    if not table or len(table) < count:
        raise _foreign(file, "its repeats are none or not distinct", made_by)
    if not np.all(np.isfinite(list(table.values()))):
        raise _foreign(file, f"a {' or '.join(names)} in its repeats is not finite", made_by)
    return table


def _made_with(file: Path, content: Mapping[str, Any], made_by: str) -> dict[str, Any]:
    made_with = content.get("made_with")
    if not isinstance(made_with, dict):
        raise _foreign(file, "it does not say what it was made with", made_by)
    return made_with


def _check_repeats(tables: Mapping[str, Table]) -> None:
    (first, table), *others = tables.items()
    for key, other in others:
        if other.keys() != table.keys():
            raise BelvedereError(
                f"{key} has repeats {sorted(other)} but {first} has {sorted(table)}, and only common "
                f"repeats can be compared; `dvc repro` brings both to the budget's number."
            )


def _check_made_alike(scene: str, made_with: Mapping[str, Mapping[str, Any]], names: tuple[str, ...]) -> None:
    (first, here), *others = made_with.items()
    for key, there in others:
        for name in names:
            if there.get(name) != here.get(name):
                by = f"BELVEDERE_{name.upper()}={here.get(name)} " if name in CHOSEN else ""
                raise BelvedereError(
                    f"scene {scene} was made differently: {name} is {there.get(name)!r} for {key} but "
                    f"{here.get(name)!r} for {first}; rerun one of them as the other was made "
                    f"(`{by}dvc repro`), or set BELVEDERE_MIX=allow to rank them nevertheless."
                )


def _check_expert(file: Path, levels: Table) -> None:
    for repeat, (_, blind, expert) in levels.items():
        if expert <= blind:
            raise BelvedereError(
                f"{file}: in repeat {repeat} the expert returns {expert:g}, not more than blind "
                f"({blind:g}), so sight has nothing to give and a score no meaning; widen the scene's "
                f"targets in params.yaml, or mend the expert, and rerun the scene's anchors."
            )


def _foreign(file: Path, why: str, made_by: str) -> BelvedereError:
    return BelvedereError(f"{file} cannot be used: {why}; delete it and run `dvc repro {made_by}`.")
