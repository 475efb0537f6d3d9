"""The closed loop on one CUDA GPU, and one whole branch there at the paper's budget.

Where there is no CUDA device the rows say so and hold no number.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.loops import VIEWS, candidates, setting
from benchmarks.rows import AT_MOST, NO_CUDA, Row, goal_row
from benchmarks.training import BRANCH, trained
from pipeline.contract import params
from pipeline.control.jobs import Job
from pipeline.learning.device import set_up_torch
from pipeline.sim.draws import draw_episodes

CANDIDATES, EPISODES, ROUNDS = 64, 64, 3  # 4,096 worlds
# Madrona-MJX's published PandaPickCube, simulation and pictures without any network, on an RTX 4090
PEER, GOAL = 36_900.0, 100_000.0
BUDGET, GOAL_MIN = "paper", 5.0


def measure() -> list[Row]:
    """A row for each scene's loop, and one for a branch."""
    there = set_up_torch().device.type == "cuda"
    note = "" if there else NO_CUDA
    rows = []
    for name in VIEWS:
        ours = frames_per_s(name) if there else None
        ratio = None if ours is None else ours / PEER
        work = "closed loop on one CUDA GPU"
        rows.append(goal_row(work, name, ours, PEER, "frames/s", ratio, GOAL / PEER, note=note))
    minutes = branch_min() if there else None
    work = f"one branch, budget {BUDGET}, one GPU"
    return [*rows, goal_row(work, BRANCH, minutes, None, "minutes", None, GOAL_MIN, AT_MOST, note)]


def frames_per_s(name: str, count: int = CANDIDATES, each: int = EPISODES) -> float:
    """Of whole calls, from drawn episodes to traces on the host; the median of a few rounds."""
    chosen = setting(name)
    loops, scene = chosen.loops(threads=1), chosen.scene
    job = Job.of(0, candidates(scene, count), draw_episodes(scene, each, np.random.default_rng(1)))
    list(loops.run([job]))  # compiles the kernels and captures the graph
    seconds = []
    for _ in range(ROUNDS):
        begin_s = time.perf_counter()
        list(loops.run([job]))
        seconds.append(time.perf_counter() - begin_s)
    return count * each * scene.frames / statistics.median(seconds)


def branch_min() -> float:
    """Minutes that the stages of one viewpoint take, as dvc.yaml runs them, from the scene's rollouts on."""
    with tempfile.TemporaryDirectory() as folder:
        repeats = params.value("budgets", BUDGET, "race", "first")
        return sum(trained(Path(folder), BUDGET, repeats).values()) / 60
