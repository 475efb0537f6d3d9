"""Lets a trained network act on the episodes kept apart, beside the expert who has no other actions."""

from __future__ import annotations

import numpy as np
import polars as pl
from stable_baselines3 import DQN

from pipeline.contract.viewpoints import Viewpoint
from pipeline.control.anchors import Policy, play
from pipeline.control.outcomes import outcomes
from pipeline.qlearning.actions import action_table
from pipeline.qlearning.tables import EPISODES
from pipeline.qlearning.task_env import Pictures
from pipeline.sim.draws import Episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds


def tried(
    model: DQN, expert: Policy, scene: Scene, view: Viewpoint, episodes: Episodes, repeat: int, threads: int
) -> pl.DataFrame:
    """One row per episode, see :data:`pipeline.qlearning.tables.EPISODES`."""
    worlds = Worlds(scene, len(episodes), threads)
    best = play(worlds, episodes, expert)
    played = play(worlds, episodes, greedy(model, scene, view, len(episodes), threads))
    table = outcomes(repeat, scene.task, episodes, played.error_m, played.reward)
    table = table.with_columns(pl.Series("expert_return", best.reward.sum(axis=1)))
    return table.select(pl.col(name).cast(kind) for name, kind in EPISODES.items())


def greedy(model: DQN, scene: Scene, view: Viewpoint, count: int, threads: int) -> Policy:
    """The policy of a trained network in ``count`` worlds, without random actions."""
    actions, pictures = action_table(scene.action_size), Pictures(scene, view, count, threads)

    def act(worlds: Worlds, frame: int) -> np.ndarray:
        chosen, _ = model.predict(pictures(worlds), deterministic=True)
        return np.asarray(actions[chosen])

    return act
