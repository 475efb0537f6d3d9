from __future__ import annotations

import numpy as np
import pytest

from pipeline.control.anchors import expert, nothing, play
from pipeline.qlearning.actions import action_table, best_restricted_expert, restricted_expert
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds


def test_every_combination_once() -> None:
    table = action_table(3)
    assert table.shape == (27, 3) and len(np.unique(table, axis=0)) == 27
    assert set(table.flat) == {-1.0, 0.0, 1.0}


@pytest.mark.parametrize("name", ["panda_2dof", "fetch_reach"])
def test_the_restricted_expert_lies_between_nothing_and_the_expert(name: str) -> None:
    scene = load_scene(name)
    worlds = Worlds(scene, 32)
    draws, episodes = (draw_episodes(scene, 32, np.random.default_rng(seed)) for seed in (1, 2))
    best = best_restricted_expert(scene, draws, 1)
    returns = [play(worlds, episodes, policy)[1].sum(1).mean() for policy in (nothing, best, expert(scene))]
    assert returns[0] < returns[1] < returns[2]
    assert (returns[1] - returns[0]) > 0.8 * (returns[2] - returns[0])


def test_it_uses_no_other_actions() -> None:
    scene = load_scene("fetch_reach")
    worlds = Worlds(scene, 8)
    worlds.reset(draw_episodes(scene, 8, np.random.default_rng(3)))
    assert set(restricted_expert(scene, 0.03)(worlds, 0).flat) <= {-1.0, 0.0, 1.0}
