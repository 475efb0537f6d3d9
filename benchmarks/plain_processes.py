"""One process per core, each with a plain loop of its own; started once, then told what to run over pipes."""

from __future__ import annotations

import multiprocessing
import os
from functools import partial
from multiprocessing.connection import Connection

import numpy as np
import torch

from benchmarks.loops import setting
from benchmarks.plain_loop import PlainLoop, renderer
from pipeline.learning.side_by_side import killed_is_told
from pipeline.sim.draws import Episodes


class Crew:
    """Plain loops of one scene, on several cores.

    Args:
        scene: its name.
        kinds: of renderers that will be asked for.
        count: how many processes.
        frames: of an episode.
    """

    def __init__(self, scene: str, kinds: tuple[str, ...], count: int, frames: int) -> None:
        spawning = multiprocessing.get_context("spawn")  # a forked OpenGL or OpenMP is a broken one
        self._pipes, self._processes = [], []
        for _ in range(count):
            here, there = spawning.Pipe()
            process = spawning.Process(target=_serve, args=(there, scene, kinds, frames), daemon=True)
            process.start()
            there.close()  # so that a process that dies is an end of file here
            self._pipes.append(here)
            self._processes.append(process)
        with killed_is_told("plain loops"):
            for pipe in self._pipes:
                pipe.recv()  # it is ready

    def run(self, kind: str, candidates: np.ndarray, episodes: Episodes) -> np.ndarray:
        """Returns (n,) of controllers (n, parameters) in episodes (n), dealt out evenly."""
        shares = np.array_split(np.arange(len(episodes)), len(self._pipes))
        with killed_is_told("plain loops"):
            for pipe, share in zip(self._pipes, shares, strict=True):
                pipe.send((kind, candidates[share], episodes[share]))
            return np.concatenate([pipe.recv() for pipe in self._pipes])

    def close(self) -> None:
        """Ends the processes."""
        for pipe in self._pipes:
            pipe.send(None)
        for process in self._processes:
            process.join()


def _serve(pipe: Connection, scene: str, kinds: tuple[str, ...], frames: int) -> None:
    """What a process does: it makes its loops, says so, and runs what it is told until it is told None."""
    os.environ["LP_NUM_THREADS"] = "0"  # one core each: Mesa's own threads would fight for them
    torch.set_num_threads(1)
    chosen = setting(scene, frames)
    loops = {kind: PlainLoop(chosen, partial(renderer, kind=kind)) for kind in kinds}
    pipe.send("ready")
    while (order := pipe.recv()) is not None:
        kind, candidates, episodes = order
        returns = [loops[kind].run(flat, episodes[i : i + 1]) for i, flat in enumerate(candidates)]
        pipe.send(np.array(returns))
