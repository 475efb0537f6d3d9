"""A search's results so far, checked: of each candidate its repeats, and whether the judge sees there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.stats.branches import ANCHORS, Results, read_anchors, read_branch
from pipeline.stats.halving import Halving, final, halve
from pipeline.stats.race import Rules
from pipeline.stats.reading import COMPARED, COMPARED_WITH_ANCHORS, check_made_alike
from pipeline.stats.replay import Race
from pipeline.storage.candidates import Candidate
from pipeline.storage.sight import Sight, read_sight

PIPELINE = "search/dvc.yaml:"


@dataclass(frozen=True)
class Searched:
    """What there is of a scene's search.

    Attributes:
        views: all candidates, by key.
        returns: of each one that was tried (repeat,) its mean return of an episode, m.
        sight: of each one that was tried, whether the judge sees there.
        anchors: ``no_op``, ``blind`` and ``expert``, each (repeat,) mean return of an episode.
        provenance: how each one's numbers were made.
    """

    views: dict[str, Candidate]
    returns: dict[str, np.ndarray]
    sight: dict[str, Sight]
    anchors: dict[str, np.ndarray]
    provenance: dict[str, dict[str, Any]]

    @property
    def compared(self) -> list[str]:
        """The candidates in the search: those at which the judge sees, and those not tried yet."""
        return [key for key in self.views if key not in self.sight or not self.sight[key].misses]

    def results(self, keys: Sequence[str], after: int = 0) -> Results:
        """Some candidates' results as a ranking has them, of the repeats after the first ``after``."""
        return Results(
            {key: self.views[key] for key in keys},
            {key: [] for key in keys},
            {key: self.returns.get(key, np.empty(0))[after:] for key in keys},
            {key: self.sight[key] for key in keys if key in self.sight},
            self.anchors,
            {key: self.provenance[key] for key in keys if key in self.provenance},
        )


@dataclass(frozen=True)
class Search:
    """Where a search stands.

    Attributes:
        keys: the candidates in it; numbers of ``halving`` are places in this list.
        halving: its rounds.
        race: of the finalists, on fresh repeats; ``None`` before its first look.
        needed: repeats that candidates lack before the search can go on; none where it has ended.
    """

    keys: list[str]
    halving: Halving
    race: Race | None
    needed: dict[str, int]

    @property
    def finalists(self) -> list[str]:
        """The finalists, best first by the halving; none before they are known."""
        return [self.keys[view] for view in self.halving.active] if self.halving.done else []

    @property
    def spent(self) -> int:
        """Rounds of the halving: the first repeats, which the race does not count."""
        return len(self.halving.rounds)


def read_searched(
    scene: str, views: dict[str, Candidate], folder: Path, anchors: Path, first: int, share: float, mix: bool
) -> Searched:
    """Reads ``evaluation.json`` and ``vae.json`` of the candidates that were tried, and the scene's anchors.

    Args:
        scene: its name.
        views: its candidates.
        folder: holds one folder per candidate that was tried.
        anchors: the scene's anchors.
        first: repeats that the anchors have.
        share: see :func:`pipeline.storage.sight.read_sight`; the first repeat decides.
        mix: accept candidates that were made differently.

    Raises:
        BelvedereError: a file is foreign, an expert is not above blind, or candidates were made differently.
    """
    tried = [key for key in views if (folder / key / "evaluation.json").is_file()]
    read = {key: read_branch(folder / key / "evaluation.json", key, views[key], PIPELINE) for key in tried}
    levels, anchors_with = read_anchors(anchors, scene, first)
    made = {key: found for key, (_, found) in read.items()}
    if made and not mix:
        check_made_alike(scene, made, COMPARED)
        check_made_alike(scene, {**made, "anchors": anchors_with}, COMPARED_WITH_ANCHORS)
    sight = {key: read_sight(folder / key / "vae.json", key, 1, share) for key in tried}
    returns = {key: values for key, (values, _) in read.items()}
    return Searched(views, returns, sight, dict(zip(ANCHORS, levels.T, strict=True)), made)


def stand(searched: Searched, finalists: int, rules: Rules, most_trainings: int | None) -> Search:
    """Runs the procedure on what there is.

    A race is ``ended`` where one more round would exceed ``most_trainings``, counting all that were made.
    """
    keys = searched.compared
    scores = searched.results(keys).scores
    values = [scores[key] for key in keys]
    halving, race = halve(values, finalists), None
    needed = dict(halving.needed)
    if halving.done and halving.active:
        race, needed = final(values, halving, rules)
        if race and race.state == "open":
            repeats = len(halving.rounds) + race.last.repeats + 1
            needed = {halving.active[view]: repeats for view in race.active}
    made = sum(map(len, searched.returns.values()))
    more = sum(repeats - len(values[view]) for view, repeats in needed.items())
    if race and needed and most_trainings is not None and made + more > most_trainings:
        race, needed = Race(race.rules, race.looks, "ended", race.out), {}
    return Search(keys, halving, race, {keys[view]: repeats for view, repeats in needed.items()})
