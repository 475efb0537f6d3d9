"""The best open-loop action sequence of a scene: what can be had without seeing anything."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from pipeline.control.anchors import blind, play
from pipeline.control.evolution import Generation, Run, Search, evolve, start
from pipeline.control.params import BlindParams, SearchSizes
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds


class BlindSearch:
    """Looks for the open-loop action sequence of the highest mean return, in the full simulator.

    A search by CMA-ES starts from each guess; after every round of generations the better half goes
    on. Actions are held for a few frames each, so that there are few numbers to be found.
    """

    def __init__(self, scene: Scene, method: BlindParams, sizes: SearchSizes, threads: int) -> None:
        self._scene, self._method, self._sizes = scene, method, sizes
        self._worlds = Worlds(scene, sizes.population * sizes.episodes, threads)

    def best(self, rng: np.random.Generator, running: Path) -> np.ndarray:
        """The best sequence found, shape (t, action_size); chosen on draws from ``rng`` alone."""
        deciding = draw_episodes(self._scene, self._worlds.count, rng)
        guesses = self.guesses(draw_episodes(self._scene, self._worlds.count, rng))
        found = [(self._value(guess, deciding), index, guess) for index, guess in enumerate(guesses)]
        searches = {index: self._start(guess, rng) for index, guess in enumerate(guesses)}
        generations = 0
        while searches:
            generations += self._sizes.generations
            what = f"blind {self._scene.name}, {len(searches)} of {len(guesses)} guesses"
            # a folder a round, so that after a kill the rounds before are found as they ended
            here = running / str(generations)
            runs = [Run(search, here / str(i), f"{what}: {i + 1}") for i, search in searches.items()]
            searches = dict(zip(searches, evolve(runs, self._judge, generations, what), strict=True))
            ends = []
            for index, search in searches.items():
                end = self.sequence(search.incumbent)
                ends.append((self._value(end, deciding), index, end))
            found += ends
            better = sorted(ends, key=lambda end: -end[0])[: len(ends) // 2]
            searches = {index: searches[index] for _, index, _ in better}
        return max(found, key=lambda one: one[0])[2]

    def guesses(self, episodes: Episodes) -> list[np.ndarray]:
        """Sequences to start from: nothing, the median way, and to each limit and back to the middle."""
        axes = list(self._scene.axes)
        way = np.median(episodes.target_m - episodes.start_m, axis=0)[axes]
        middle = np.median(episodes.target_m, axis=0)[axes]
        space = self._scene.params.workspace
        still = np.zeros((self._scene.frames, len(axes)))
        result = [still, self._travel(still, way, 0)]
        for limit in (np.asarray(space.low_m)[axes], np.asarray(space.high_m)[axes]):
            for axis in range(len(axes)):
                there = still.copy()
                there[: self._frames_across(axis), axis] = np.sign(limit - middle)[axis]
                back = np.where(np.arange(len(axes)) == axis, middle - limit, way)
                result.append(self._travel(there, back, self._frames_across(axis)))
        return result

    def _frames_across(self, axis: int) -> int:
        """Frames in which the tip surely comes to a limit, at most half the episode."""
        index = self._scene.axes[axis]
        space = self._scene.params.workspace
        width_m = space.high_m[index] - space.low_m[index]
        return min(self._scene.frames // 2, round(width_m / self._speed_m()))

    def _speed_m(self) -> float:
        """Metres a frame at full action: about half the largest displacement, as the tip lags."""
        return self._scene.params.displacement_m / 2

    def _travel(self, actions: np.ndarray, way_m: np.ndarray, begin: int) -> np.ndarray:
        """``actions`` and from frame ``begin`` on, on each axis, the given way at full speed."""
        result = actions.copy()
        for axis, distance in enumerate(way_m):
            frames = round(abs(distance) / self._speed_m())
            result[begin : begin + frames, axis] = np.sign(distance)
        return result

    def sequence(self, numbers: np.ndarray) -> np.ndarray:
        """Held actions, flat, to a sequence (t, action_size) within [-1, 1]."""
        held = np.clip(numbers.reshape(-1, self._scene.action_size), -1.0, 1.0)
        return np.repeat(held, self._method.hold_frames, axis=0)[: self._scene.frames]

    def _start(self, guess: np.ndarray, rng: np.random.Generator) -> Search:
        pieces = np.array_split(guess, range(self._method.hold_frames, len(guess), self._method.hold_frames))
        flat = np.concatenate([piece.mean(axis=0) for piece in pieces])
        candidates, draws = rng.spawn(2)
        return start(flat, self._sizes.population, self._method, candidates, draws)

    def _judge(self, generations: Sequence[Generation]) -> Iterator[np.ndarray]:
        return map(self._returns, generations)

    def _returns(self, generation: Generation) -> np.ndarray:
        candidates = generation.candidates
        episodes = draw_episodes(self._scene, self._sizes.episodes, generation.draws).tiled(len(candidates))
        sequences = np.stack([self.sequence(c) for c in candidates])
        each = np.repeat(sequences, self._sizes.episodes, axis=0)
        _, reward = play(self._worlds, episodes, lambda worlds, frame: each[:, frame])
        return np.asarray(reward.sum(axis=1).reshape(len(candidates), -1).mean(axis=1))

    def _value(self, actions: np.ndarray, episodes: Episodes) -> float:
        return float(play(self._worlds, episodes, blind(actions))[1].sum(axis=1).mean())
