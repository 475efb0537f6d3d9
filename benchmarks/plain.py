"""The closed loop on all cores against a plain one: a process per core, one world each, nothing batched."""

from __future__ import annotations

import statistics
from collections.abc import Callable

import numpy as np

from benchmarks import timing
from benchmarks.loops import VIEWS, WORLDS, candidates, setting
from benchmarks.plain_loop import AS_IT_COMES, STRIPPED
from benchmarks.plain_processes import Crew
from benchmarks.rows import Row, goal_row
from pipeline.contract.machine import cores
from pipeline.control.policy import Controllers
from pipeline.sim.draws import draw_episodes

GOALS = {STRIPPED: 6.0, AS_IT_COMES: 30.0}
EACH = {STRIPPED: 8, AS_IT_COMES: 1}  # episodes that a process runs in a round
FRAMES = 25  # of a peer's episode; a reset takes less than a percent of them
ROUNDS = 7


def measure() -> list[Row]:
    """Two rows per scene: medians over rounds in which ours and both peers are measured in turn."""
    return [row for name in VIEWS for row in measure_scene(name)]


def measure_scene(name: str) -> list[Row]:
    """The rows of one scene."""
    chosen = setting(name)
    loop, crew = chosen.loop(cores()), Crew(name, tuple(GOALS), cores(), FRAMES)
    episodes = draw_episodes(chosen.scene, WORLDS, np.random.default_rng(1))
    flat = candidates(chosen.scene, WORLDS)
    controllers = Controllers.of(flat, chosen.scene.action_size)

    def told(kind: str) -> Callable[[], object]:
        count = EACH[kind] * cores()
        return lambda: crew.run(kind, flat[:count], episodes[:count])

    work = {"ours": lambda: loop.run(controllers, episodes), **{kind: told(kind) for kind in GOALS}}
    frames = {"ours": WORLDS * chosen.scene.frames}
    frames |= {kind: EACH[kind] * cores() * FRAMES for kind in GOALS}
    for run in work.values():
        run()  # the first call compiles
    rates: dict[str, list[float]] = {kind: [] for kind in work}
    for _ in range(ROUNDS):
        for kind, run in work.items():
            rates[kind].append(frames[kind] / timing.seconds(run))
    crew.close()
    return [_row(name, kind, rates["ours"], rates[kind]) for kind in GOALS]


def _row(scene: str, kind: str, ours: list[float], peer: list[float]) -> Row:
    ratio = statistics.median(mine / other for mine, other in zip(ours, peer, strict=True))
    rates = statistics.median(ours), statistics.median(peer)
    work = f"closed loop against plain, {kind}"
    return goal_row(work, scene, *rates, "frames/s", ratio, GOALS[kind])
