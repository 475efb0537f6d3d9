"""The closed loops of several world models, such as a viewpoint's repeats: on the CPU or on a GPU."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Protocol

import numpy as np
import torch

from pipeline.contract.viewpoints import Viewpoint
from pipeline.control.device_loop import DeviceLoop
from pipeline.control.jobs import Job, Networks
from pipeline.control.loop import Loop, Trace, Workers
from pipeline.sim.scene import Scene


class Loops(Protocol):
    """Runs jobs; which networks they see through is each job's own."""

    scene: Scene

    def run(self, jobs: Sequence[Job]) -> Iterable[Trace]:
        """What happened in each job, in their order.

        Raises:
            BelvedereError: a controller or its world model gives actions that are no numbers.
        """


class HostLoops:
    """A :class:`Loop` for each world model, over the same workers: all jobs' shards share the cores."""

    def __init__(self, scene: Scene, view: Viewpoint, networks: Sequence[Networks], threads: int) -> None:
        self.scene, workers = scene, Workers(scene, view, threads)
        self._loops = [Loop(workers, each.encoder, each.rnn) for each in networks]

    def run(self, jobs: Sequence[Job]) -> Iterator[Trace]:
        """Each job's trace, as soon as it and those before it are done."""
        started = [self._loops[job.member].start(job.controllers, job.episodes) for job in jobs]
        return (trace() for trace in started)


def closed_loops(
    scene: Scene, view: Viewpoint, networks: Sequence[Networks], device: torch.device, threads: int
) -> Loops:
    """The loops for a device: on CUDA all jobs are one batch there, on the CPU ``threads`` share each."""
    if device.type == "cuda":
        return DeviceLoop(scene, view, networks, device)
    return HostLoops(scene, view, networks, threads)


def mean_returns(loops: Loops, jobs: Sequence[Job], candidates: int) -> list[np.ndarray]:
    """Mean returns (p,) of the ``candidates`` p of each job of :meth:`Job.of`, over the job's episodes."""
    return [trace.returns.reshape(candidates, -1).mean(axis=1) for trace in loops.run(jobs)]
