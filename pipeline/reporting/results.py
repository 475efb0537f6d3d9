"""Reading what the stages found: rankings, anchors, and the tables of each ranked branch."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import polars as pl
from pydantic import ValidationError

from pipeline.contract.errors import BelvedereError
from pipeline.reporting.rankings import Ranked, Ranking
from pipeline.reporting.tables import Anchors, Evaluation, Mdnrnn, Table, Vae, read, read_of_view

CURVE_COLUMNS = {
    "repeat": pl.Int64,
    "generation": pl.Int64,
    "frames": pl.Int64,
    "mean": pl.Float64,
    "best": pl.Float64,
}


@dataclass(frozen=True)
class View:
    """A ranked viewpoint with the tables of its branch."""

    key: str
    label: str
    ranked: Ranked
    vae: Vae
    mdnrnn: Mdnrnn
    evaluation: Evaluation
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
    try:
        return [Coverage.model_validate(row) for row in pl.read_csv(path).to_dicts()]
    except (FileNotFoundError, ValidationError, pl.exceptions.PolarsError):
        raise BelvedereError(
            f"{path} is missing or holds no table of simulated races; "
            "`python -m benchmarks.coverage` makes it."
        ) from None


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
    ranking = read(Ranking, rankings / f"{name}.json", f"ranking@{name}")
    if ranking.scene != name or not ranking.viewpoints:
        raise BelvedereError(
            f"{rankings / f'{name}.json'} ranks {len(ranking.viewpoints)} viewpoint(s) of scene "
            f"{ranking.scene!r}, not those of {name!r}; run `dvc repro ranking@{name}`."
        )
    ordered = sorted(ranking.viewpoints.items(), key=lambda item: (item[1].rank, item[0]))
    return SceneResults(
        name=name,
        ranking=ranking,
        anchors=read(Anchors, anchors / f"{name}.json", f"anchors@{name}"),
        views=tuple(_view(name, key, ranked, branches / key) for key, ranked in ordered),
    )


def _view(scene: str, key: str, ranked: Ranked, folder: Path) -> View:
    angles = (ranked.theta_deg, ranked.phi_deg)
    return View(
        key=key,
        label=short(key, scene),
        ranked=ranked,
        vae=read_of_view(Vae, folder / "vae.json", f"vae@{key}", scene, angles),
        mdnrnn=read_of_view(Mdnrnn, folder / "mdnrnn.json", f"mdnrnn@{key}", scene, angles),
        evaluation=read_of_view(Evaluation, folder / "evaluation.json", f"evaluation@{key}", scene, angles),
        curve=_read_curve(folder / "controller.csv", f"controller@{key}"),
        dqn_curve=_read_dqn_curve(folder / "dqn.csv", f"dqn@{key}"),
    )


def short(key: str, scene: str) -> str:
    """A branch's name within its scene: ``a`` for ``panda_2dof-a``."""
    return key.removeprefix(f"{scene}-")


def _read_curve(path: Path, made_by: str) -> pl.DataFrame:
    if not path.is_file():
        raise BelvedereError(f"{path} is missing; `dvc repro {made_by}` makes it.")
    curve = _read_csv(path, made_by)
    if curve.is_empty():
        raise BelvedereError(f"{path} holds no generation; `dvc repro {made_by}` makes it anew.")
    return curve


def _read_dqn_curve(path: Path, made_by: str) -> pl.DataFrame | None:
    """None where no network was trained."""
    curve = _read_csv(path, made_by) if path.is_file() else None
    return None if curve is None or curve.is_empty() else curve


def _read_csv(path: Path, made_by: str) -> pl.DataFrame:
    try:
        return pl.read_csv(path, schema_overrides=CURVE_COLUMNS).select(*CURVE_COLUMNS)
    except pl.exceptions.PolarsError as error:
        reason = " ".join(str(error).split())[:120]
        raise BelvedereError(
            f"{path} is no learning curve ({reason}); delete it and run `dvc repro {made_by}`."
        ) from None
