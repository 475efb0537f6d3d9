"""`./run search SCENE`: where on the sphere, by halving and a race of finalists, until there is an answer."""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pydantic import NonNegativeInt, PositiveInt

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError, unknown
from pipeline.contract.machine import CORES_VARIABLE, cores
from pipeline.storage import scratch
from pipeline.storage.allocation import ALLOCATION_FILE, Allocation, write_allocation
from pipeline.storage.artefacts import writing
from pipeline.storage.candidates import candidates_of, read_finalists, write_finalists
from pipeline.storage.tables import read_model
from runner.dvc import read_faster
from runner.lock import check_lock
from runner.parameters import check_parameters
from runner.plan import Job, Pipeline, jobs, read_pipeline
from runner.race import allocate
from runner.rankings import Part
from runner.rwlock import drop_damaged_rwlock
from runner.schedule import Schedule, default_jobs, on_this_terminal

FOUND, PICTURES, PUBLISHED = Path("search/found"), Path("search/pictures"), Path("reports/searches")
MOUNTED = Path("search/mounting")
COPIES = {".json": "search.json", ".csv": "candidates.csv", "_map.csv": "map.csv"}  # of a scene's results
SEARCH_LOCK = Path("search/dvc.lock")
FILE = "search/dvc.yaml"
PLACE = (sys.executable, "-m", "pipeline.placement")


class Sentence(Part):
    """An answer in words."""

    sentence: str


class Found(Part):
    """What stage `search` wrote: whether the search is open, and which repeats it lacks."""

    answer: Sentence | None
    progress: str
    open: bool
    needed: dict[str, PositiveInt]
    finalists: list[str]
    most_repeats: PositiveInt
    trainings_left: int | None
    trainings: NonNegativeInt


def stage(scene: str) -> str:
    """DVC's name of the stage that says where a scene's search stands."""
    return f"{FILE}:search@{scene}"


def read_found(scene: str) -> Found:
    """Where a scene's search stands.

    Raises:
        BelvedereError: it is missing, or is no search's.
    """
    return read_model(Found, FOUND / f"{scene}.json", stage(scene))


@dataclass
class Search:
    """What is left to do until a scene's search has its answer.

    Attributes:
        pipeline: the stages behind the search.
        scene: its scene.
        candidates: of the scene.
        cores: of the machine; a round of the race gives work to all of them.
        until_s: by the monotonic clock, when no more rounds are begun; ``None``: whenever it takes.
        allocation: how many repeats each branch has been given.
    """

    pipeline: Pipeline
    scene: str
    candidates: Sequence[str]
    cores: int
    until_s: float | None
    allocation: Allocation
    late: bool = field(default=False, init=False)

    def begin(self) -> list[Job]:
        """What dvc.lock lacks, or the next round."""
        behind = self.pipeline.of({self.scene, *self.candidates}, self.pipeline.changed)
        return jobs(behind, self.candidates, 0) or self.next_round()

    def more(self, job: Job) -> list[Job]:
        """The next round once the search's stage has run; nothing after other jobs."""
        return self.next_round() if job.name == f"search@{self.scene}" else []

    def next_round(self) -> list[Job]:
        """Says how the search stands, and gives the candidates that need them more repeats."""
        found = read_found(self.scene)
        print(found.progress, flush=True)
        if not found.open:
            return []
        if self.until_s is not None and time.monotonic() > self.until_s:
            self.late = True
            return []
        given = with_repeats(self.allocation, self.scene, self._wanted(found))
        if given == self.allocation:
            raise BelvedereError(
                f"the search of {self.scene} needs more repeats of {', '.join(sorted(found.needed))}, which "
                f"{ALLOCATION_FILE} gives already; run `dvc repro {stage(self.scene)}`."
            )
        write_allocation(given)
        self.allocation = given
        round_ = self.pipeline.of({self.scene, *found.needed}, self.pipeline.allocated)
        return jobs(round_, self.candidates, 0)

    def _wanted(self, found: Found) -> dict[str, int]:
        """What the search needs; in the race enough for all cores, since the start of a stage costs time.

        Never more repeats than a finalist may have, nor more trainings than the search may.
        """
        if found.answer is None:
            return dict(found.needed)
        count = max(1, self.cores // len(found.needed))
        if found.trainings_left is not None:
            count = min(count, max(1, found.trainings_left // len(found.needed)))
        most = min(found.most_repeats, params.MOST_REPEATS)
        return {key: max(needed, min(needed + count - 1, most)) for key, needed in found.needed.items()}


def with_repeats(allocation: Allocation, scene: str, wanted: Mapping[str, int]) -> Allocation:
    """The allocation in which some candidates have at least so many repeats."""
    entries = {
        key: one.model_copy(update={"repeats": max(one.repeats, wanted.get(key, 1))})
        for key, one in allocation.branches.items()
    }
    scenes = allocation.scenes | {scene: max(allocation.scenes[scene], *wanted.values())}
    return allocation.model_copy(update={"scenes": scenes, "branches": entries})


def main(argv: Sequence[str]) -> int:
    """Runs the command and returns the exit status."""
    asked = _parser().parse_args(argv)
    check_parameters()
    check_lock()
    check_lock(SEARCH_LOCK)
    searches = params.mapping("searches")
    if asked.scene not in searches:
        raise unknown("scene below searches in params.yaml", asked.scene, searches)
    if subprocess.run([*PLACE, "--scene", asked.scene]).returncode:
        return 1
    search(asked.scene, asked.hours)
    publish(asked.scene)
    if mount(asked.scene):
        publish(asked.scene)
    return report()


def search(scene: str, hours: float | None) -> None:
    """Runs rounds until the search has its answer, or the hours are over.

    Raises:
        BelvedereError: a stage failed, or the scratch store cannot be written to.
    """
    begun = time.monotonic()
    read_faster()
    drop_damaged_rwlock()
    allocation = allocate()
    candidates = list(candidates_of(scene))
    until = None if hours is None else begun + 3600 * hours
    going = Search(read_pipeline([stage(scene)]), scene, candidates, cores(), until, allocation)
    to_do = going.begin()
    if to_do:
        _schedule(going.more).run(to_do)
    found = read_found(scene)
    if going.late:
        print(f"{hours:g} hours are over; `./run search {scene}` goes on from here.")
    if found.answer:
        print(f"{scene}: {found.answer.sentence}")


def _schedule(more: Callable[[Job], list[Job]]) -> Schedule:
    logs = scratch.root() / "logs"
    logs.mkdir(parents=True, exist_ok=True)
    print(f"what the stages say is in {logs}", flush=True)
    shared = None if CORES_VARIABLE in os.environ else cores()
    return Schedule(default_jobs(), shared, os.environ, logs, more)


def mount(scene: str) -> bool:
    """Tries the finalists of a search that is over with their cameras off their places; says if any were.

    Raises:
        BelvedereError: a stage failed.
    """
    found = read_found(scene)
    if found.open or not found.finalists:
        return False
    views = candidates_of(scene)
    others = {key: view for key, view in read_finalists().items() if view.scene != scene}
    write_finalists({**others, **{key: views[key] for key in found.finalists}})
    pipeline = read_pipeline([f"{FILE}:mounting@{key}" for key in found.finalists])
    to_do = jobs(pipeline.of({scene, *found.finalists}, pipeline.changed), found.finalists, 0)
    _schedule(lambda job: []).run(to_do)
    return True


def publish(scene: str) -> None:
    """Copies what was found to where the report reads it, whole.

    The report depends on copies, so that no `./run` and no `dvc repro` trains a candidate.
    """
    found = read_found(scene)
    with writing(PUBLISHED / scene) as folder:
        for part in ("pictures", "mounting"):
            (folder / part).mkdir(parents=True)
        for name, published in COPIES.items():
            shutil.copyfile(FOUND / f"{scene}{name}", folder / published)
        for key in found.finalists:
            picture = PICTURES / key / "view" / "view.png"
            if picture.is_file():
                shutil.copyfile(picture, folder / "pictures" / f"{key}.png")
            mounted = MOUNTED / scene / f"{key}.json"
            if mounted.is_file() and not found.open:
                shutil.copyfile(mounted, folder / "mounting" / f"{key}.json")


def report() -> int:
    """Makes the page of what there is; a scene that was never ranked is named on it."""
    return on_this_terminal("repro", "--single-item", "trials", "people", "report")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="./run search", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("scene", metavar="SCENE", help="one of `searches` in params.yaml")
    parser.add_argument("--hours", type=hours, help="begin no round after so many; it can be continued")
    return parser


def hours(text: str) -> float:
    """A number of hours.

    Raises:
        ValueError: it is none, or not above 0.
    """
    found = float(text)
    if not 0 < found < float("inf"):
        raise ValueError(text)
    return found
