"""The judge without one of its parts, as the report reads and orders it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pipeline.reporting.tables import Table
from pipeline.storage.tables import read_model

WHOLE = "whole"


class Variant(Table):
    """What a judge reached: scores by repeat, and the change from the whole judge's, repeat by repeat."""

    scores: list[float]
    score: float
    change: float | None = None
    low: float | None = None
    high: float | None = None


class Ablation(Table):
    """A viewpoint's judge, whole and without parts, ``KEY.json``; angles in degrees."""

    theta_deg: float
    phi_deg: float
    repeats: int
    budget: str
    seed: int
    variants: dict[str, Variant]


@dataclass(frozen=True)
class SceneAblations:
    """The viewpoints of a scene that were tried without parts.

    Attributes:
        scene: its name.
        views: by branch, the whole judge's best first.
    """

    scene: str
    views: dict[str, Ablation]

    def foreign(self, budget: str, seed: int) -> list[str]:
        """The viewpoints that were tried with another budget or seed."""
        return [key for key, own in self.views.items() if (own.budget, own.seed) != (budget, seed)]

    @property
    def variants(self) -> list[str]:
        """The parts that were taken away, in the order of the table."""
        return [name for name in next(iter(self.views.values())).variants if name != WHOLE]

    @property
    def orders(self) -> dict[str, list[str]]:
        """How the whole judge and each variant order the viewpoints, best first."""
        return {
            name: sorted(self.views, key=lambda key: -self.views[key].variants[name].score)
            for name in (WHOLE, *self.variants)
        }


def read_ablations(folder: Path) -> list[SceneAblations]:
    """Each scene's, in the order of their names; none where nothing was tried.

    Raises:
        BelvedereError: a table is foreign.
    """
    found = []
    for scene in sorted(path for path in folder.glob("*") if path.is_dir()):
        files = sorted(scene.glob("*.json"))
        views = {f.stem: read_model(Ablation, f, f"ablation/dvc.yaml:ablation@{f.stem}") for f in files}
        if views:
            ordered = sorted(views, key=lambda key: -views[key].variants[WHOLE].score)
            found.append(SceneAblations(scene.name, {key: views[key] for key in ordered}))
    return found
