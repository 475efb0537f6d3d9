"""Policies that see no pictures; what they reach says what a return means in a scene."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipeline.sim.draws import Episodes
from pipeline.sim.expert import Expert
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds

Policy = Callable[[Worlds, int], np.ndarray]  # worlds and frame to actions (n, action_size)


def play(worlds: Worlds, episodes: Episodes, policy: Policy) -> tuple[np.ndarray, np.ndarray]:
    """Runs a policy.

    Returns:
        ``(tip_m, reward)``: shapes (n, t + 1, 3) and (n, t).
    """
    worlds.reset(episodes)
    tips, rewards = [worlds.tip], []
    for frame in range(worlds.scene.frames):
        rewards.append(worlds.step(policy(worlds, frame)))
        tips.append(worlds.tip)
    return np.stack(tips, axis=1), np.stack(rewards, axis=1)


def nothing(worlds: Worlds, frame: int) -> np.ndarray:
    """The policy of standing still."""
    return np.zeros((worlds.count, worlds.scene.action_size))


def heading_for(scene: Scene, goal_m: np.ndarray) -> Policy:
    """The policy of going to given places (n, 3), m, as the expert goes to targets."""
    feedback = Expert(scene)
    return lambda worlds, frame: feedback(worlds.tip, goal_m)


def expert(scene: Scene) -> Policy:
    """The policy that knows where tip and target are."""
    feedback = Expert(scene)
    return lambda worlds, frame: feedback(worlds.tip, worlds.target)
