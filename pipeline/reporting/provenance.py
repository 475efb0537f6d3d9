"""Where the results come from: revision, parameters, versions, machines, seconds."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.reporting.results import SceneResults
from pipeline.storage import scratch

SCENE_STAGES = ("rollouts", "anchors", "ranking")
BRANCH_STAGES = ("frames", "geometry", "operator", "vae", "latents", "mdnrnn", "controller", "evaluation")


@dataclass(frozen=True)
class Costs:
    """Seconds per stage, as this machine recorded them.

    Attributes:
        stages: column names.
        rows: by scene or branch, the seconds of each stage (None: not recorded here).
        machines: where they were measured.
        total_s: sum over all that is recorded.
        missing: how many of the stages have no record here.
    """

    stages: tuple[str, ...]
    rows: dict[str, tuple[float | None, ...]]
    machines: tuple[str, ...]
    total_s: float
    missing: int

    def mean_of(self, stage: str, scene: SceneResults) -> float | None:
        """Mean seconds of a stage over the scene's views; ``None`` where none is recorded."""
        column = self.stages.index(stage)
        known = [s for view in scene.views if (s := self.rows[view.key][column]) is not None]
        return sum(known) / len(known) if known else None


def revision(folder: Path = Path()) -> str:
    """The git revision, and whether code or parameters differ from it."""
    found = _git(folder, "rev-parse", "HEAD")
    if not found:
        return "not under git"
    changed = _git(folder, "status", "--porcelain", "--", "pipeline", "params.yaml")
    return f"{found} with uncommitted changes in pipeline/ or params.yaml" if changed else found


def _git(folder: Path, *arguments: str) -> str:
    try:
        result = subprocess.run(
            ["git", "-C", str(folder), *arguments], capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        return ""
    return result.stdout.strip() if result.returncode == 0 else ""


def costs(scenes: Sequence[SceneResults]) -> Costs:
    """Seconds of the stages behind the ranked scenes, from the scratch store's records."""
    records = _records()
    rows: dict[str, tuple[float | None, ...]] = {}
    stages = (*SCENE_STAGES[:2], *BRANCH_STAGES, SCENE_STAGES[2])
    expected = 0
    for scene in scenes:
        for name, nouns in [(scene.name, SCENE_STAGES), *((v.key, BRANCH_STAGES) for v in scene.views)]:
            expected += len(nouns)
            rows[name] = tuple(
                records.get(f"{noun}@{name}", (None, ""))[0] if noun in nouns else None for noun in stages
            )
    known = [s for row in rows.values() for s in row if s is not None]
    names = {f"{noun}@{name}" for name in rows for noun in stages}
    machines = sorted({machine for stage, (_, machine) in records.items() if stage in names})
    return Costs(stages, rows, tuple(machines), sum(known), expected - len(known))


def _records() -> dict[str, tuple[float, str]]:
    """By stage, seconds and machine; a record that cannot be read is skipped."""
    found: dict[str, tuple[float, str]] = {}
    for path in sorted((scratch.root() / "seconds").glob("*.json")):
        try:
            record = json.loads(path.read_text(encoding="utf-8"))
            found[str(record["stage"])] = (float(record["seconds"]), str(record["machine"]))
        except (ValueError, KeyError, TypeError):
            continue
    return found


def provenance(scenes: Iterable[SceneResults]) -> list[tuple[list[str], dict[str, Any]]]:
    """Devices and versions, scenes made alike under one entry."""
    groups: list[tuple[list[str], dict[str, Any]]] = []
    for scene in scenes:
        for names, facts in groups:
            if facts == scene.ranking.provenance:
                names.append(scene.name)
                break
        else:
            groups.append(([scene.name], dict(scene.ranking.provenance)))
    return groups


def flat(tree: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """A tree of parameters as (dotted name, value) rows."""
    rows: list[tuple[str, str]] = []
    for name, node in tree.items():
        if isinstance(node, Mapping):
            rows += flat(node, f"{prefix}{name}.")
        else:
            rows.append((f"{prefix}{name}", json.dumps(node, ensure_ascii=False)))
    return rows
