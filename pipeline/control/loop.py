"""The closed loop: camera, encoder, controller, simulator and RNN, for many worlds at once.

Worlds are cut into shards of a fixed size. A shard runs its whole episode in one thread, on its own
simulations and its own render context, so threads never wait for each other within an episode, and
no number depends on how many threads there are. Rendering, physics and torch release the GIL.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, fields

import numpy as np
import torch

from pipeline.contract.viewpoints import Viewpoint
from pipeline.control.policy import Controllers
from pipeline.rendering.renderer import Renderer
from pipeline.sim.draws import Episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds
from pipeline.storage.stage import WORKER
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.mdnrnn import MdnRnn

SHARD = 32  # worlds; part of the method: another size may round otherwise in the last bits


@dataclass(frozen=True, eq=False)
class Trace:
    """What happened in n episodes of t frames.

    Attributes:
        qpos: generalised positions before each action and after the last, (n, t + 1, nq).
        tip_m: tip positions at the same times, (n, t + 1, 3).
        action: (n, t, actions).
        reward: paper eq. (1), after each action, (n, t).
        error_m: what the reward counts, before each action and after the last, (n, t + 1).
    """

    qpos: np.ndarray
    tip_m: np.ndarray
    action: np.ndarray
    reward: np.ndarray
    error_m: np.ndarray

    @property
    def returns(self) -> np.ndarray:
        """Paper eq. (2): the sum of the rewards, (n,)."""
        return np.asarray(self.reward.sum(axis=1))

    def part(self, episodes: slice) -> Trace:
        """What happened in some of the episodes."""
        return Trace(**{f.name: getattr(self, f.name)[episodes] for f in fields(Trace)})

    @staticmethod
    def joined(parts: Sequence[Trace], count: int) -> Trace:
        """The first ``count`` episodes of all parts."""
        joined = {f.name: np.concatenate([getattr(p, f.name) for p in parts])[:count] for f in fields(Trace)}
        return Trace(**joined)


class _Worker:
    """One shard's simulations and pictures; used by one thread at a time."""

    def __init__(self, scene: Scene, view: Viewpoint) -> None:
        self.worlds, self.images = Worlds(scene, SHARD), Renderer(scene, view, SHARD)

    def run(self, encoder: Encoder, rnn: MdnRnn, controllers: Controllers, episodes: Episodes) -> Trace:
        worlds, state = self.worlds, rnn.initial_state(SHARD)
        worlds.reset(episodes)
        qpos, tips, actions, rewards, errors = [worlds.qpos], [worlds.tip], [], [], [worlds.error]
        for _ in range(worlds.scene.frames):
            latents = encoder(self.images.render(qpos[-1], worlds.target))
            action = controllers(latents, state.h)
            rewards.append(worlds.step(action.numpy().astype(np.float64)))
            state = rnn.step(latents, action, state)
            qpos.append(worlds.qpos)
            tips.append(worlds.tip)
            actions.append(action.numpy())
            errors.append(worlds.error)
        return Trace(*(np.stack(series, axis=1) for series in (qpos, tips, actions, rewards, errors)))


class Workers:
    """Simulations and pictures of shards, for all loops of a viewpoint to share.

    Args:
        scene: the compiled scene.
        view: where the camera stands.
        threads: how many shards run at a time; decides the speed and no number.
    """

    def __init__(self, scene: Scene, view: Viewpoint, threads: int) -> None:
        self.scene = scene
        self._free = [_Worker(scene, view) for _ in range(threads)]
        # each thread has an OpenMP pool of its own: one thread each, or they fight for the cores
        self._pool = ThreadPoolExecutor(threads, WORKER, initializer=torch.set_num_threads, initargs=(1,))

    def start(self, shard: Callable[[_Worker], Trace]) -> Future[Trace]:
        """Has a shard run by the next worker that is free."""

        def run() -> Trace:
            worker = self._free.pop()
            try:
                return shard(worker)
            finally:
                self._free.append(worker)

        return self._pool.submit(run)


class Loop:
    """Runs controllers in worlds that they see through one world model.

    Args:
        workers: who runs the shards.
        encoder: pictures to z.
        rnn: what h comes from.
    """

    def __init__(self, workers: Workers, encoder: Encoder, rnn: MdnRnn) -> None:
        self._workers, self._encoder, self._rnn = workers, encoder, rnn

    def start(self, controllers: Controllers, episodes: Episodes) -> Callable[[], Trace]:
        """Starts ``controllers[i]`` in ``episodes[i]``, for all i; what is returned waits for their trace.

        Raises:
            BelvedereError: (while waiting) a controller or its world model gives actions that are no numbers.
        """
        count = len(episodes)
        if len(controllers) != count:
            raise ValueError(f"{len(controllers)} controllers for {count} episodes")

        def shard(begin: int) -> Future[Trace]:
            members = np.minimum(np.arange(begin, begin + SHARD), count - 1)  # the last one fills up
            chosen, starts = controllers[torch.from_numpy(members)], episodes[members]
            return self._workers.start(lambda worker: worker.run(self._encoder, self._rnn, chosen, starts))

        shards = [shard(begin) for begin in range(0, count, SHARD)]
        return lambda: Trace.joined([each.result() for each in shards], count)

    def run(self, controllers: Controllers, episodes: Episodes) -> Trace:
        """The trace of :meth:`start`."""
        return self.start(controllers, episodes)()
