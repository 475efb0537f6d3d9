"""Where the closed loop's time goes: one shard, in one thread, by that thread's processor time.

The loop's own worker runs; the parts that it calls are wrapped, so what is measured is what runs.
"""

from __future__ import annotations

import copy
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from torch import Tensor

from benchmarks.loops import Setting, candidates
from benchmarks.rows import Row
from pipeline.control.loop import SHARD, Loop, Workers
from pipeline.control.policy import Controllers
from pipeline.learning.device import set_up_torch
from pipeline.sim.draws import draw_episodes
from pipeline.worldmodel.encoder import Encoder

TABLE = "closed loop in one thread, per frame of one world"
RENDER, REST = "render", "rest"
PARTS = (RENDER, "physics", "IK", "encode", "RNN", "controller", REST)
ROUNDS = 3


@dataclass
class Clock:
    """Seconds by part; a part's own, without those of parts within it, so they add up to the whole."""

    now_s: Callable[[], float] = time.thread_time
    seconds: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    _within: list[float] = field(default_factory=lambda: [0.0])

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Counts what happens within it towards ``name``."""
        begin = self.now_s()
        self._within.append(0.0)
        yield
        spent = self.now_s() - begin
        self.seconds[name] += spent - self._within.pop()
        self._within[-1] += spent

    def timed(self, name: str, work: Callable[..., Any]) -> Callable[..., Any]:
        """``work``, counted towards ``name`` at each call."""

        def counted(*arguments: Any, **named: Any) -> Any:
            with self.part(name):
                return work(*arguments, **named)

        return counted


@dataclass(frozen=True)
class TimedControllers(Controllers):
    """Controllers whose calls a clock counts."""

    clock: Clock

    def __getitem__(self, index: Tensor) -> TimedControllers:
        return TimedControllers(self.weight[index], self.bias[index], self.clock)

    def __call__(self, latents: Tensor, hidden: Tensor) -> Tensor:
        with self.clock.part("controller"):
            return super().__call__(latents, hidden)


def profile(chosen: Setting) -> list[Row]:
    """Two rows of the small table, in milliseconds and in percent."""
    clock = Clock()
    loop = timed_loop(chosen, clock)
    episodes = draw_episodes(chosen.scene, SHARD, np.random.default_rng(1))
    plain = Controllers.of(candidates(chosen.scene, SHARD), chosen.scene.action_size)
    controllers = TimedControllers(plain.weight, plain.bias, clock)
    loop.run(controllers, episodes)  # the first call compiles
    clock.seconds.clear()
    for _ in range(ROUNDS):
        loop.run(controllers, episodes)
    ms = {part: 1e3 * clock.seconds[part] / (ROUNDS * SHARD * chosen.scene.frames) for part in PARTS}
    whole = sum(ms.values())
    share = {part: 100 * spent / whole for part, spent in ms.items()}
    name: Row = {"table": TABLE, "scene": chosen.scene.name}
    return [{**name, "unit": "ms", **ms, "all": whole}, {**name, "unit": "%", **share, "all": 100.0}]


def timed_loop(chosen: Setting, clock: Clock) -> Loop:
    """The closed loop with one worker, whose parts a clock watches."""
    encoder: Any = clock.timed("encode", Encoder(chosen.vae, set_up_torch()))
    rnn = copy.copy(chosen.rnn)
    workers = Workers(chosen.scene, chosen.view, threads=1)
    worker = workers._free[0]
    watched = (
        (worker, "run", REST),
        (worker.images, "render", RENDER),
        (worker.worlds, "reset", "physics"),
        (worker.worlds, "step", "physics"),
        (worker.worlds._arm_controller, "reset", "IK"),
        (worker.worlds._arm_controller, "move", "IK"),
        (rnn, "step", "RNN"),
    )
    for thing, method, part in watched:
        setattr(thing, method, clock.timed(part, getattr(thing, method)))
    return Loop(workers, encoder, rnn)
