"""Which stages one process runs, and which processes wait for which.

DVC locks a stage's outputs for writing even while it only looks whether the stage changed, and its option
--wait-for-lock does not cover that lock. So of two processes that both have rollouts@scene in their way, the
second ends with "busy" while frames@… of the first reads the rollouts. Hence every stage is in one job only,
and a job names its stages one by one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from pipeline.contract.errors import BelvedereError
from pipeline.storage.allocation import ALLOCATION_FILE


@dataclass(frozen=True)
class Job:
    """Stages that one process runs, one after the other.

    Attributes:
        name: the branch, or the stage that branches share.
        stages: DVC's names of the stages, in an order in which they can run.
        after: the names of the jobs that must be done before.
        place: of jobs that could begin, the one with the lowest number does.
    """

    name: str
    stages: tuple[str, ...]
    after: frozenset[str]
    place: int


@dataclass(frozen=True)
class Pipeline:
    """What DVC knows of the stages behind the targets.

    Attributes:
        waits: for each stage, in the order in which `dvc repro` takes them, the stages it directly waits for.
        changed: the stages that are not as dvc.lock has them.
        allocated: the stages that depend on the number of repeats.
    """

    waits: Mapping[str, Collection[str]]
    changed: frozenset[str]
    allocated: frozenset[str]

    def of(self, keys: Collection[str], changed: Collection[str]) -> Pipeline:
        """The stages of some branches and scenes alone, of which some count as changed."""
        kept = [stage for stage in self.waits if key(stage) in keys]
        waits = {stage: [w for w in self.waits[stage] if w in kept] for stage in kept}
        return Pipeline(waits, frozenset(changed).intersection(kept), self.allocated)


def read_pipeline(targets: Sequence[str]) -> Pipeline:
    """Asks DVC for the stages behind ``targets``, in the working directory.

    Raises:
        BelvedereError: DVC knows no such target, cannot read its files, or is at work already.
    """
    from dvc.exceptions import DvcException
    from dvc.repo import Repo, lock_repo
    from dvc.repo.reproduce import collect_stages, get_active_graph, plan_repro

    try:
        with Repo() as repo, lock_repo(repo):
            graph = get_active_graph(repo.index.graph)
            stages = plan_repro(graph, collect_stages(repo, targets))
            waits = {s.addressing: [w.addressing for w in graph.successors(s)] for s in stages}
            changed = frozenset(s.addressing for s in stages if s.changed())
            reads = {s.addressing: {str(dep.def_path) for dep in s.deps} for s in stages}
    except DvcException as error:
        raise BelvedereError(f"DVC cannot plan the run: {error}") from None
    allocated = {stage for stage, paths in reads.items() if ALLOCATION_FILE.as_posix() in paths}
    return Pipeline(waits, changed, frozenset(allocated))


def jobs(pipeline: Pipeline, branches: Collection[str], place: int) -> list[Job]:
    """The jobs that have something to do, in the order of dvc.yaml.

    A branch is one job, and so is each stage of a scene: its rollouts, anchors, ranking. The stages in which
    scenes meet are in no job.
    """
    job_of: dict[str, str] = {}
    for stage in pipeline.waits:
        if key(stage) in branches:
            job_of[stage] = key(stage)
        elif key(stage):
            job_of[stage] = stage.rpartition(":")[2]  # without its dvc.yaml: it names a log file
    made = [_job(name, job_of, pipeline.waits, place) for name in dict.fromkeys(job_of.values())]
    return _with_something_to_do(made, pipeline.changed)


def key(stage: str) -> str:
    """What dvc.yaml repeats a stage over: ``study`` of ``frames@study``; empty where it stands once."""
    return stage.partition("@")[2]


def _job(name: str, job_of: Mapping[str, str], waits: Mapping[str, Collection[str]], place: int) -> Job:
    stages = tuple(stage for stage, job in job_of.items() if job == name)
    after = {job_of[awaited] for stage in stages for awaited in waits[stage]}
    return Job(name, stages, frozenset(after - {name}), place)


def _with_something_to_do(made: Sequence[Job], changed: Collection[str]) -> list[Job]:
    """Drops the jobs that are done already; one that waits for a job with something to do may be no more."""
    names = {job.name for job in made if not set(job.stages).isdisjoint(changed)}
    while more := {job.name for job in made if job.name not in names and job.after & names}:
        names |= more
    return [Job(job.name, job.stages, job.after & names, job.place) for job in made if job.name in names]
