"""CMA-ES: its own time in a generation against the closed loop's, at the quick budget."""

from __future__ import annotations

import statistics
import time

import numpy as np

from benchmarks.loops import setting
from benchmarks.rows import AT_MOST, Row, goal_row
from pipeline.contract import params
from pipeline.contract.machine import cores
from pipeline.control.evolution import start
from pipeline.control.jobs import Job
from pipeline.control.loops import mean_returns
from pipeline.control.params import ControllerParams, SearchSizes
from pipeline.control.policy import hidden_weights, parameters
from pipeline.sim.draws import draw_episodes

SCENES = ("panda_1dof", "panda_2dof", "fetch_reach")  # 289, 578 and 867 parameters
GOAL = 0.05
GENERATIONS = 4


def measure() -> list[Row]:
    """One row per number of parameters: medians over the generations of a search."""
    return [measure_scene(name) for name in SCENES]


def measure_scene(name: str) -> Row:
    """The row of one scene; ask and tell are ours, judging in the closed loop is the peer."""
    sizes = params.section(SearchSizes, "budgets", "quick", "controller")
    method = params.section(ControllerParams, "controller")
    chosen, draws = setting(name), np.random.default_rng(1)
    actions = chosen.scene.action_size
    loops, count = chosen.loops(cores()), parameters(actions)
    shares = np.where(hidden_weights(actions), method.hidden_share, 1.0)
    search = start(np.zeros(count), sizes.population, method, np.random.default_rng(2), draws, shares)
    ours, peer = [], []
    for _ in range(GENERATIONS + 1):
        episodes = draw_episodes(chosen.scene, sizes.episodes, draws)
        begin = time.perf_counter()
        asked = np.array(search.strategy.ask())
        middle = time.perf_counter()
        (returns,) = mean_returns(loops, [Job.of(0, asked, episodes)], sizes.population)
        end = time.perf_counter()
        search.strategy.tell(list(asked), list(-returns))
        ours.append(1e3 * (middle - begin + time.perf_counter() - end))
        peer.append(1e3 * (end - middle))
    ours, peer = ours[1:], peer[1:]  # the first call compiles
    ratio = statistics.median(mine / other for mine, other in zip(ours, peer, strict=True))
    times = statistics.median(ours), statistics.median(peer)
    return goal_row(f"CMA-ES, {count} parameters", name, *times, "ms", ratio, GOAL, AT_MOST)
