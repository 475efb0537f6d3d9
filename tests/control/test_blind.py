from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.control.anchors import blind, nothing, play
from pipeline.control.blind import BlindSearch
from pipeline.control.evolution import Run
from pipeline.control.params import BlindParams, SearchSizes
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds

METHOD = BlindParams(sigma=0.2, diagonal=False, hold_frames=10)
SIZES = SearchSizes(population=4, episodes=3, generations=1)


def test_it_finds_that_the_target_lies_below(tmp_path: Path) -> None:
    """In the 1-DOF scene every episode starts above its target: going down some way pays."""
    loaded = load_scene("panda_1dof")
    scene = replace(loaded, params=loaded.params.model_copy(update={"frames": 20}))
    found = BlindSearch(scene, METHOD, SIZES, threads=1).best(np.random.default_rng(1), tmp_path)
    assert found.shape == (20, 1)
    assert np.abs(found).max() <= 1.0
    worlds, fresh = Worlds(scene, 16), draw_episodes(scene, 16, np.random.default_rng(2))
    returns = [play(worlds, fresh, policy)[1].sum(axis=1).mean() for policy in (blind(found), nothing)]
    assert returns[0] > returns[1] + 0.3


def test_it_starts_from_nothing_the_median_way_and_each_limit() -> None:
    scene = load_scene("panda_2dof")
    search = BlindSearch(scene, METHOD, SIZES, threads=1)
    guesses = search.guesses(draw_episodes(scene, 64, np.random.default_rng(1)))
    assert len(guesses) == 2 + 2 * scene.action_size
    assert not guesses[0].any()
    low, high = scene.params.workspace.low_m, scene.params.workspace.high_m
    worlds, episodes = Worlds(scene, 8), draw_episodes(scene, 8, np.random.default_rng(2))
    reached = [play(worlds, episodes, blind(guess))[0] for guess in guesses[2:]]
    for axis, world_axis in enumerate(scene.axes):
        to_low, to_high = (reached[side * scene.action_size + axis][:, :, world_axis] for side in (0, 1))
        assert np.median(to_low.min(axis=1)) < low[world_axis] + 0.03
        assert np.median(to_high.max(axis=1)) > high[world_axis] - 0.03


class Killed(BaseException):
    """As good as kill -9: nothing in the code catches it."""


def test_wherever_it_is_killed_it_finds_the_same(tmp_path: Path) -> None:
    loaded, sizes = load_scene("panda_1dof"), SIZES.model_copy(update={"generations": 3})
    scene = replace(loaded, params=loaded.params.model_copy(update={"frames": 20}))

    def found(running: Path, most: float = np.inf) -> tuple[np.ndarray, int]:
        """What is found, and in how many generations; killed where it wants more than ``most``."""
        calls, original = 0, Run.advance

        def advance(run: Run, *given: Any) -> None:
            nonlocal calls
            if calls == most:
                raise Killed
            calls += 1
            original(run, *given)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Run, "advance", advance)
            best = BlindSearch(scene, METHOD, sizes, threads=1).best(np.random.default_rng(1), running)
        return best, calls

    undisturbed, calls = found(tmp_path / "whole")
    first_round = 4 * sizes.generations  # of the four guesses
    assert calls > first_round
    for most in range(first_round + 1, calls, 2):
        with pytest.raises(Killed):
            found(tmp_path / str(most), most)
        np.testing.assert_array_equal(found(tmp_path / str(most))[0], undisturbed)
