"""A Q-network's actions, {-1, 0, 1} on each controlled axis, and the expert who has no others."""

from __future__ import annotations

from itertools import product

import numpy as np

from pipeline.control.anchors import Policy, play
from pipeline.sim.draws import Episodes
from pipeline.sim.expert import Expert
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds

_REACHES_M = (0.01, 0.02, 0.03, 0.04, 0.05)


def action_table(axes: int) -> np.ndarray:
    """All 3^axes actions, shape (3^axes, axes): shares of the largest displacement."""
    return np.array(list(product((-1.0, 0.0, 1.0), repeat=axes)))


def restricted_expert(scene: Scene, reach_m: float) -> Policy:
    """The expert with these actions: on each axis the one that, moving ``reach_m``, comes nearest.

    Args:
        scene: the compiled scene.
        reach_m: how far an action of 1 is taken to move the tip on its axis.
    """
    expert, axes = Expert(scene), list(scene.axes)

    def act(worlds: Worlds, frame: int) -> np.ndarray:
        state = worlds.state
        way = (expert.waypoint(state) - state.tip_m)[:, axes]
        return np.asarray(np.clip(np.round(way / reach_m), -1.0, 1.0))

    return act


def best_restricted_expert(scene: Scene, draws: Episodes, threads: int) -> Policy:
    """The restricted expert whose ``reach_m`` returns most on ``draws``.

    A push's effect depends on how the arm is moving, so no single number is right.
    """
    worlds = Worlds(scene, len(draws), threads)

    def returned(reach_m: float) -> float:
        played = play(worlds, draws, restricted_expert(scene, reach_m))
        return float(played.reward.sum(axis=1).mean())

    return restricted_expert(scene, max(_REACHES_M, key=returned))
