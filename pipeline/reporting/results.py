"""Reading what the stages found: rankings, anchors, and the tables of each ranked branch."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import polars as pl
from pydantic import ValidationError

from pipeline.contract.errors import BelvedereError
from pipeline.reporting.curve_files import read_curve, read_dqn_curve
from pipeline.reporting.rankings import RankedView, Ranking
from pipeline.reporting.tables import Anchors, Evaluation, Mdnrnn, Operator, Table, Vae, read_of_view
from pipeline.storage.tables import read_model, read_rows


@dataclass(frozen=True)
class View:
    """A ranked viewpoint with the tables of its branch."""

    key: str
    label: str
    ranked: RankedView
    vae: Vae
    mdnrnn: Mdnrnn
    evaluation: Evaluation
    operator: Operator
    curve: pl.DataFrame
    dqn_curve: pl.DataFrame | None


@dataclass(frozen=True)
class SceneResults:
    """A ranked scene; ``views`` stand in the order of their ranks."""

    name: str
    ranking: Ranking
    anchors: Anchors
    views: tuple[View, ...]

    @property
    def searched(self) -> tuple[View, ...]:
        """The views at which controllers were searched for: where the judge can see."""
        return tuple(view for view in self.views if not view.ranked.misses)

    @property
    def trainings(self) -> int:
        """How many trainings all its views have had."""
        return sum(view.ranked.repeats for view in self.views)

    def labels(self, keys: Iterable[str]) -> list[str]:
        """Short names of branches."""
        return [short(key, self.name) for key in keys]


class Coverage(Table):
    """Simulated races of one kind.

    Attributes:
        population: how trainings scatter.
        views: how many race.
        situation: how the views truly differ.
        runs: how many races were simulated.
        wrong: share that ended with a false statement.
        covered: share in which the printed interval of the lead held the true lead.
        trainings: mean number spent.
    """

    population: str
    views: int
    situation: str
    runs: int
    wrong: float
    covered: float
    trainings: float


def read_coverage(path: Path) -> list[Coverage]:
    """The simulated races.

    Raises:
        BelvedereError: the file is missing or foreign.
    """
    what, remedy = "table of simulated races", "`python -m benchmarks.coverage` makes it"
    try:
        rows = [Coverage.model_validate(r) for r in read_rows(path, Coverage.model_fields, what, remedy)]
    except ValidationError as error:
        raise BelvedereError(f"{path} holds no {what} ({error.errors()[0]['msg']}); {remedy}.") from None
    if not rows:
        raise BelvedereError(f"{path} holds no {what}; {remedy}.")
    return rows


def read_results(
    scenes: Sequence[str], rankings: Path, branches: Path, anchors: Path
) -> tuple[list[SceneResults], list[str]]:
    """Reads all scenes that have been ranked; of branches, only those a ranking names.

    Returns:
        The ranked scenes in the order of ``scenes``, and the names of those not ranked yet.

    Raises:
        BelvedereError: no scene is ranked, or a table is missing, foreign or incomplete.
    """
    present = [name for name in scenes if (rankings / f"{name}.json").is_file()]
    if not present:
        raise BelvedereError(
            f"{rankings} holds a ranking of none of the scenes in params.yaml "
            f"({', '.join(scenes) or 'none'}); `dvc repro ranking` makes them."
        )
    found = [_scene(name, rankings, branches / name, anchors) for name in present]
    return found, [name for name in scenes if name not in present]


def _scene(name: str, rankings: Path, branches: Path, anchors: Path) -> SceneResults:
    ranking = read_model(Ranking, rankings / f"{name}.json", f"ranking@{name}")
    if ranking.scene != name or not ranking.viewpoints:
        raise BelvedereError(
            f"{rankings / f'{name}.json'} ranks {len(ranking.viewpoints)} viewpoint(s) of scene "
            f"{ranking.scene!r}, not those of {name!r}; run `dvc repro ranking@{name}`."
        )
    ordered = sorted(ranking.viewpoints.items(), key=lambda item: (item[1].rank, item[0]))
    return SceneResults(
        name=name,
        ranking=ranking,
        anchors=read_model(Anchors, anchors / f"{name}.json", f"anchors@{name}"),
        views=tuple(_view(name, key, ranked, branches / key) for key, ranked in ordered),
    )


def _view(scene: str, key: str, ranked: RankedView, folder: Path) -> View:
    angles = (ranked.theta_deg, ranked.phi_deg)
    return View(
        key=key,
        label=short(key, scene),
        ranked=ranked,
        vae=read_of_view(Vae, folder / "vae.json", f"vae@{key}", scene, angles),
        mdnrnn=read_of_view(Mdnrnn, folder / "mdnrnn.json", f"mdnrnn@{key}", scene, angles),
        evaluation=read_of_view(Evaluation, folder / "evaluation.json", f"evaluation@{key}", scene, angles),
        operator=read_of_view(Operator, folder / "operator.json", f"operator@{key}", scene, angles),
        curve=read_curve(folder / "controller.csv", f"controller@{key}", ranked.repeats),
        dqn_curve=read_dqn_curve(folder / "dqn.csv", f"dqn@{key}"),
    )


def short(key: str, scene: str) -> str:
    """A branch's name within its scene: ``a`` for ``panda_2dof-a``."""
    return key.removeprefix(f"{scene}-")
