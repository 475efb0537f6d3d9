"""The race: round by round, viewpoints that are still in it get more repeats, until there is an answer."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint, named_viewpoints
from pipeline.storage.allocation import (
    ALLOCATION_FILE,
    Allocation,
    Entry,
    read_allocation,
    write_allocation,
)
from pipeline.storage.candidates import FIRST_REPEATS, searched_viewpoints
from runner.plan import Job, Pipeline, jobs
from runner.rankings import read_ranking


def allocate() -> Allocation:
    """The allocation for the parameters as they are, written where it was another.

    Entries that count stay; a branch without one gets as many repeats as its scene, at least the first ones;
    a candidate of a search gets one.
    """
    budget, seed = params.budget(), params.seed()
    views = named_viewpoints()
    former = read_allocation() if ALLOCATION_FILE.is_file() else None
    if former and (former.budget, former.seed) != (budget, seed):
        former = None
    first = {scene: params.first_repeats(scene) for scene in params.value("scenes")}
    scenes = dict(first)
    if former:
        scenes |= {name: max(first[name], count) for name, count in former.scenes.items() if name in first}
    entries = {}
    for key, view in views.items():
        count = _counted(former, key, view) or scenes[view.scene]
        entries[key] = Entry(**view.model_dump(), repeats=max(first[view.scene], count))
    for key, view in searched_viewpoints().items():
        entries[key] = Entry(**view.model_dump(), repeats=_counted(former, key, view) or FIRST_REPEATS)
    found = Allocation(budget=budget, seed=seed, scenes=scenes, branches=entries)
    if former != found:
        write_allocation(found)
    return found


def _counted(former: Allocation | None, key: str, view: Viewpoint) -> int | None:
    """A branch's repeats by the allocation so far, if that is of the same viewpoint."""
    entry = former.branches.get(key) if former else None
    same = entry and entry.model_dump(exclude={"repeats"}) == view.model_dump()
    return entry.repeats if entry and same else None


def soonest_answered(allocation: Allocation) -> list[str]:
    """The scenes, those of fewest trainings first: so the first answer is there soonest."""
    trainings, searched = Counter[str](), searched_viewpoints()
    for key, entry in allocation.branches.items():
        trainings[entry.scene] += entry.repeats if key not in searched else 0
    return sorted(allocation.scenes, key=lambda scene: trainings[scene])


def grown(allocation: Allocation, scene: str, active: Collection[str], repeats: int) -> Allocation:
    """The allocation in which the active branches of a scene have at least so many repeats."""
    entries = {
        key: entry.model_copy(update={"repeats": max(repeats, entry.repeats)}) if key in active else entry
        for key, entry in allocation.branches.items()
    }
    scenes = allocation.scenes | {scene: max(repeats, allocation.scenes[scene])}
    return allocation.model_copy(update={"scenes": scenes, "branches": entries})


@dataclass
class Race:
    """What is left to do until each scene has its answer.

    Attributes:
        pipeline: the stages behind the scenes' rankings, as they were before anything ran.
        branches: the names of the branches.
        scenes: in the order in which their answers are wanted.
        cores: of the machine; a round gives work to all of them.
        allocation: how many repeats each branch has been given.
    """

    pipeline: Pipeline
    branches: Collection[str]
    scenes: Sequence[str]
    cores: int
    allocation: Allocation

    def begin(self) -> list[Job]:
        """What dvc.lock lacks, and the next round of the scenes that lack nothing but have no answer."""
        first = []
        for place, scene in enumerate(self.scenes):
            behind = self.pipeline.of({scene, *self._keys(scene)}, self.pipeline.changed)
            first += jobs(behind, self.branches, place) or self.next_round(scene)
        return first

    def more(self, job: Job) -> list[Job]:
        """The next round of a scene, once its ranking is made; nothing after other jobs."""
        scene = next((s for s in self.scenes if job.name == f"ranking@{s}"), None)
        return self.next_round(scene) if scene else []

    def next_round(self, scene: str) -> list[Job]:
        """Says how the scene's race stands; gives the viewpoints in it more repeats if it is open."""
        ranking = read_ranking(scene)
        race = ranking.race
        if not race.open:
            print(f"{scene}: {ranking.answer.sentence}", flush=True)
            return []
        print(ranking.answer.progress, flush=True)
        active = set(race.active)
        # starting a viewpoint's stages costs less than a training that the race does not need
        step = max(1, self.cores // max(1, len(active)))
        given = grown(self.allocation, scene, active, min(ranking.most, race.common + step))
        if given == self.allocation:
            raise BelvedereError(
                f"the race of {scene} is open, but {', '.join(sorted(active)) or 'none'} have all repeats "
                f"that {ALLOCATION_FILE} can give; run `dvc repro ranking@{scene}`."
            )
        write_allocation(given)
        self.allocation = given
        round_ = self.pipeline.of({scene, *active}, self.pipeline.allocated)
        return jobs(round_, self.branches, self.scenes.index(scene))

    def _keys(self, scene: str) -> list[str]:
        return [key for key in self.branches if self.allocation.branches[key].scene == scene]
