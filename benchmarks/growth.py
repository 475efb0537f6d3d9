"""How time and memory grow: with worlds, with candidates of a generation, with repeats of an evaluation."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.loops import candidates, setting
from benchmarks.rows import Row
from pipeline.contract import params
from pipeline.contract.machine import cores
from pipeline.control.jobs import Job
from pipeline.control.loops import mean_returns
from pipeline.control.params import EvaluationSizes, SearchSizes
from pipeline.control.policy import Controllers
from pipeline.learning.side_by_side import killed_is_told
from pipeline.sim.draws import draw_episodes

SCENE = "panda_2dof"
WORLDS, FRAMES = (8, 32, 128, 512, 2048, 8192), 8  # short episodes, or the last count would take minutes
CANDIDATES, REPEATS = (4, 8, 16, 32), (1, 2, 4)
AT_LEAST_S = 1.0  # a short work is done again until so much has passed
DRAWN = 128  # different episodes; more worlds run them several times


def measure() -> list[Row]:
    """Rows of two small tables; worlds are counted in a process of their own, for its memory's sake."""
    spawning = multiprocessing.get_context("spawn")
    with killed_is_told("growth with worlds"), ProcessPoolExecutor(1, mp_context=spawning) as fresh:
        worlds = fresh.submit(worlds_rows).result()
    return [*worlds, *candidates_rows(), *repeats_rows()]


def worlds_rows() -> list[Row]:
    """Frames a second and peak memory by number of worlds; it rises, so the peak is the last count's."""
    chosen = setting(SCENE, FRAMES)
    loop = chosen.loop(cores())
    few = draw_episodes(chosen.scene, DRAWN, np.random.default_rng(1))
    loop.run(Controllers.of(candidates(chosen.scene, DRAWN), chosen.scene.action_size), few)  # compiles
    rows: list[Row] = []
    for count in WORLDS:
        episodes = few.tiled(-(-count // DRAWN))[np.arange(count)]
        controllers = Controllers.of(candidates(chosen.scene, count), chosen.scene.action_size)
        seconds = _seconds(partial(loop.run, controllers, episodes))
        rows.append({"worlds": count, "seconds": seconds, "frames/s": count * FRAMES / seconds})
        rows[-1]["peak MiB"] = peak_mib()
    return [{"table": f"growth with worlds ({SCENE}, episodes of {FRAMES} frames)", **row} for row in rows]


def candidates_rows() -> list[Row]:
    """Seconds to evaluate so many candidates, each in the quick budget's episodes."""
    sizes = params.section(SearchSizes, "budgets", "quick", "controller")
    chosen = setting(SCENE)
    loops = chosen.loops(cores())
    episodes = draw_episodes(chosen.scene, sizes.episodes, np.random.default_rng(1))
    flat = candidates(chosen.scene, max(CANDIDATES))

    def evaluated(count: int) -> None:
        mean_returns(loops, [Job.of(0, flat[:count], episodes)], count)

    evaluated(max(CANDIDATES))  # the first call compiles
    each = {n: _seconds(partial(evaluated, n)) for n in CANDIDATES}
    return [_growth("candidates evaluated", count, seconds) for count, seconds in each.items()]


def repeats_rows() -> list[Row]:
    """Seconds to evaluate so many repeats, each with a loop and episodes of its own, as the stage does."""
    sizes = params.section(EvaluationSizes, "budgets", "quick", "evaluation")
    chosen = setting(SCENE)
    episodes = draw_episodes(chosen.scene, sizes.episodes, np.random.default_rng(1))
    flat = candidates(chosen.scene, max(REPEATS))

    def evaluate(repeats: int) -> None:
        for r in range(repeats):
            one = Controllers.of(flat[r : r + 1], chosen.scene.action_size, each=len(episodes))
            chosen.loop(cores()).run(one, episodes)

    evaluate(1)  # the first call compiles
    each = {n: _seconds(partial(evaluate, n)) for n in REPEATS}
    return [_growth("repeats evaluated", count, seconds) for count, seconds in each.items()]


def _growth(what: str, count: int, seconds: float) -> Row:
    table = f"growth with candidates and repeats ({SCENE}, quick budget)"
    return {"table": table, "what": what, "count": count, "seconds": seconds, "seconds each": seconds / count}


def _seconds(work: Callable[[], object]) -> float:
    """Seconds of one call."""
    begin, calls = time.perf_counter(), 0
    while calls == 0 or time.perf_counter() - begin < AT_LEAST_S:
        work()
        calls += 1
    return (time.perf_counter() - begin) / calls


def peak_mib() -> float | None:
    """The most memory that this process has held, MiB, as Linux tells it; None elsewhere.

    ``getrusage`` would also count what the parent held when it started this process.
    """
    status = Path("/proc/self/status")
    if not status.is_file():
        return None
    found = [line.split()[1] for line in status.read_text().splitlines() if line.startswith("VmHWM:")]
    return int(found[0]) / 1024 if found else None
