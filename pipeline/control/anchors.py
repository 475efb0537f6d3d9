"""Policies that see no pictures; what they earn says what a return means in a scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pipeline.sim.draws import Episodes
from pipeline.sim.expert import Expert
from pipeline.sim.scene import Scene
from pipeline.sim.tasks.base import State
from pipeline.sim.worlds import Worlds

Policy = Callable[[Worlds, int], np.ndarray]  # worlds and frame to actions (n, action_size)


class Played(NamedTuple):
    """What happened in n episodes of t frames.

    Attributes:
        tip_m: at the start and after each frame, (n, t + 1, 3).
        reward: paper eq. (1), after each frame, (n, t).
        error_m: what the reward counts, at the start and after each frame, (n, t + 1).
    """

    tip_m: np.ndarray
    reward: np.ndarray
    error_m: np.ndarray


def play(worlds: Worlds, episodes: Episodes, policy: Policy) -> Played:
    """Runs a policy, from the episodes' first frame to their last."""
    worlds.reset(episodes)
    tips, rewards, errors = [worlds.tip], [], [worlds.error]
    for frame in range(worlds.scene.frames):
        rewards.append(worlds.step(policy(worlds, frame)))
        tips.append(worlds.tip)
        errors.append(worlds.error)
    return Played(*(np.stack(series, axis=1) for series in (tips, rewards, errors)))


def nothing(worlds: Worlds, frame: int) -> np.ndarray:
    """The policy of standing still."""
    return np.zeros((worlds.count, worlds.scene.action_size))


def expert(scene: Scene) -> Policy:
    """The policy that knows where everything is."""
    feedback = Expert(scene)
    return lambda worlds, frame: feedback(worlds.state)


def believing(
    scene: Scene, target_m: np.ndarray, point: Callable[[np.ndarray], np.ndarray] = lambda tip_m: tip_m
) -> Policy:
    """The expert, if it knows its tip only, and believes the rest.

    Args:
        scene: the compiled scene.
        target_m: where it believes the targets to be at the start and after each frame, (n, t + 1, 3), m.
        point: what it believes of what shall come there, by its tips (n, 3); called once a frame.
    """
    feedback = Expert(scene)

    def act(worlds: Worlds, frame: int) -> np.ndarray:
        tip_m = worlds.tip
        return feedback(State(tip_m, point(tip_m), target_m[:, frame], target_m[:, frame + 1]))

    return act
