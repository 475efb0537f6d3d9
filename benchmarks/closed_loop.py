"""The closed loop at 128 worlds, in frames a second, against rendering the same worlds and nothing else."""

from __future__ import annotations

import statistics
import time

import numpy as np

from benchmarks.loop_profile import profile
from benchmarks.loops import VIEWS, WORLDS, Setting, candidates, setting
from benchmarks.rows import Row, goal_row
from pipeline.contract.machine import cores
from pipeline.control.policy import Controllers
from pipeline.rendering.renderer import ParallelRenderer
from pipeline.sim.draws import draw_episodes
from pipeline.sim.worlds import target_paths

ROUNDS = 5
GOAL = 0.85  # while rendering is the bound: what bounds it, the profile says


def measure() -> list[Row]:
    """One row per scene: medians over rounds in which both take turns, on all cores; then the profile."""
    settings = [setting(name) for name in VIEWS]
    goals = [measure_scene(chosen) for chosen in settings]
    return goals + [row for chosen in settings for row in profile(chosen)]


def measure_scene(chosen: Setting) -> Row:
    """The row of one scene."""
    scene, loop = chosen.scene, chosen.loop(cores())
    renderer = ParallelRenderer(scene, chosen.view, cores())
    episodes = draw_episodes(scene, WORLDS, np.random.default_rng(1))
    controllers = Controllers.of(candidates(scene, WORLDS), scene.action_size)
    trace = loop.run(controllers, episodes)  # also the first call, which compiles
    seen = trace.qpos[:, :-1].reshape(-1, trace.qpos.shape[2])  # the states that the closed loop rendered
    targets = target_paths(scene, episodes)[:, :-1].reshape(-1, 3)
    renderer.render(seen[:WORLDS], targets[:WORLDS], drawn=lambda count: None)
    ours, peer = [], []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        loop.run(controllers, episodes)
        middle = time.perf_counter()
        renderer.render(seen, targets, drawn=lambda count: None)
        end = time.perf_counter()
        ours.append(WORLDS * scene.frames / (middle - begin))
        peer.append(WORLDS * scene.frames / (end - middle))
    ratio = statistics.median(mine / other for mine, other in zip(ours, peer, strict=True))
    rates = statistics.median(ours), statistics.median(peer)
    return goal_row("closed loop against pure rendering", scene.name, *rates, "frames/s", ratio, GOAL)
