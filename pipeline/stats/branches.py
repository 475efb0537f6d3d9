"""A scene's results as the stages `evaluation`, `vae` and `anchors` left them, checked and in one unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError, unknown
from pipeline.contract.viewpoints import Viewpoint, named_viewpoints
from pipeline.stats.reading import (
    COMPARED,
    COMPARED_WITH_ANCHORS,
    by_repeat,
    check_made_alike,
    check_viewpoint,
    foreign,
    provenance,
)
from pipeline.storage.artefacts import read_json
from pipeline.storage.sight import Sight, read_sight

ANCHORS = ("no_op", "blind", "expert")
_BESIDE = ("geometry", "operator", "vae", "dqn")  # whose numbers stand in a ranking, too


@dataclass(frozen=True)
class Results:
    """A scene's results.

    Attributes:
        branches: the viewpoints, by key; each viewpoint once.
        duplicates: for each key, the other branches with the same viewpoint.
        returns: of each branch (repeat,) its mean return of an episode; repeats may differ in number.
        sight: of each branch, whether the judge sees there.
        anchors: ``no_op``, ``blind`` and ``expert``, each (repeat,) mean return of an episode, of the first
            repeats only.
        provenance: how each branch's numbers were made, by key.
    """

    branches: dict[str, Viewpoint]
    duplicates: dict[str, list[str]]
    returns: dict[str, np.ndarray]
    sight: dict[str, Sight]
    anchors: dict[str, np.ndarray]
    provenance: dict[str, dict[str, Any]]

    @property
    def first(self) -> int:
        """The repeats that every branch has."""
        return len(self.anchors["blind"])

    @property
    def blind_m(self) -> float:
        """The return at score 0."""
        return float(self.anchors["blind"].mean())

    @property
    def unit_m(self) -> float:
        """The return from score 0 to 1: fixed, since each repeat's own would add its scatter."""
        return float(self.anchors["expert"].mean()) - self.blind_m

    @property
    def scores(self) -> dict[str, np.ndarray]:
        """Of each branch (repeat,) its share of the way from target-blind (0) to the expert (1)."""
        return {key: (own - self.blind_m) / self.unit_m for key, own in self.returns.items()}

    @property
    def seen(self) -> list[str]:
        """The branches at which the judge sees."""
        return [key for key in self.branches if not self.sight[key].misses]

    def common(self, keys: Sequence[str]) -> np.ndarray:
        """(view, repeat) scores of some branches over the repeats that all of them have."""
        scores = self.scores
        least = min(len(scores[key]) for key in keys)
        return np.array([scores[key][:least] for key in keys])


def scene_branches(
    scene: str, path: Path = params.PARAMS_FILE
) -> tuple[dict[str, Viewpoint], dict[str, list[str]]]:
    """The scene's branches in params.yaml, and for each the later ones with the same viewpoint.

    Candidates (``viewpoints``) come before ``study`` (``viewpoint``), so a study of a candidate's
    viewpoint is that candidate's duplicate.

    Raises:
        BelvedereError: no branch is of this scene, or one is not valid.
    """
    named = named_viewpoints(path)
    kept: dict[tuple[str, float, float], str] = {}
    duplicates: dict[str, list[str]] = {}
    for key, branch in named.items():
        if branch.scene == scene:
            first = kept.setdefault(branch.place, key)
            duplicates.setdefault(first, []).extend([key] if key != first else [])
    if not kept:
        raise unknown("scene with a viewpoint", scene, {branch.scene for branch in named.values()})
    return {key: named[key] for key in kept.values()}, duplicates


def read_results(
    scene: str,
    folder: Path,
    anchors: Path,
    first: int,
    sight_share: float,
    mix: bool = False,
    path: Path = params.PARAMS_FILE,
) -> Results:
    """Reads ``evaluation.json`` and ``vae.json`` of the scene's branches, and the anchors' file.

    Args:
        scene: the scene's name.
        folder: holds one folder per branch; those that params.yaml does not name are skipped.
        anchors: the scene's anchors.
        first: repeats that every branch and the anchors have.
        sight_share: see :func:`pipeline.storage.sight.read_sight`.
        mix: accept branches that were made differently.
        path: the parameter file.

    Raises:
        BelvedereError: a file is missing or foreign, repeats are lacking, an expert is not above blind,
            or the branches were made differently.
    """
    branches, duplicates = scene_branches(scene, path)
    read = {key: read_branch(folder / key / "evaluation.json", key, branches[key]) for key in branches}
    levels, anchors_with = read_anchors(anchors, scene, first)
    returns = {key: values for key, (values, _) in read.items()}
    made = {key: found for key, (_, found) in read.items()}
    _check_repeats(returns, first)
    if not mix:
        check_made_alike(scene, made, COMPARED)
        check_made_alike(scene, {**made, "anchors": anchors_with}, COMPARED_WITH_ANCHORS)
    sight = {key: read_sight(folder / key / "vae.json", key, first, sight_share) for key in branches}
    return Results(branches, duplicates, returns, sight, dict(zip(ANCHORS, levels.T, strict=True)), made)


def read_branch(
    file: Path, key: str, branch: Viewpoint, pipeline: str = ""
) -> tuple[np.ndarray, dict[str, Any]]:
    """A branch's mean returns (repeat,) and what they were made with.

    ``pipeline`` is what DVC's names of its stages begin with, where the root's dvc.yaml has them not.
    """
    made_by = f"{pipeline}evaluation@{key}"
    content = read_json(file, made_by)
    meant = (branch.scene, branch.theta, branch.phi)
    check_viewpoint(file, content, meant, made_by)
    for stage in _BESIDE:
        if (other := file.with_name(f"{stage}.json")).is_file():
            beside = f"{pipeline}{stage}@{key}"
            check_viewpoint(other, read_json(other, beside), meant, beside)
    return by_repeat(file, content, ("return",), made_by)[:, 0], provenance(file, content, made_by)


def read_anchors(file: Path, scene: str, first: int) -> tuple[np.ndarray, dict[str, Any]]:
    """(repeat, anchor) returns, and what they were made with."""
    made_by = f"anchors@{scene}"
    content = read_json(file, made_by)
    if content.get("scene") != scene:
        raise foreign(file, f"it is of scene {content.get('scene')!r}, not {scene!r}", made_by)
    levels = by_repeat(file, content, ANCHORS, made_by)
    if len(levels) != first:
        raise foreign(file, f"it has {len(levels)} repeats, but the budget's race.first is {first}", made_by)
    _check_expert(file, levels)
    return levels, provenance(file, content, made_by)


def unit_of(anchors: Path, scene: str) -> float:
    """The return from score 0 to 1 of a scene, m, by its anchors' file.

    Raises:
        BelvedereError: the file is missing or foreign, or the expert is not above blind.
    """
    levels, _ = read_anchors(anchors, scene, params.first_repeats(scene))
    _, blind, expert = levels.mean(axis=0)
    return float(expert - blind)


def _check_repeats(returns: dict[str, np.ndarray], first: int) -> None:
    for key, values in returns.items():
        if len(values) < first:
            raise BelvedereError(
                f"{key} has {len(values)} repeats, but a view is compared from {first} on (the budget's "
                f"race.first); `dvc repro evaluation@{key}` makes them."
            )


def _check_expert(file: Path, levels: np.ndarray) -> None:
    for repeat, (_, blind, expert) in enumerate(levels):
        if expert <= blind:
            raise BelvedereError(
                f"{file}: in repeat {repeat} the expert returns {expert:g}, not more than target-blind "
                f"({blind:g}), so sight has nothing to give and a score no meaning; widen the scene's "
                f"targets in params.yaml, or correct the expert, and rerun the scene's anchors."
            )
