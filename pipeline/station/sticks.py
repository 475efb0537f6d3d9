"""From the gamepad's sticks to an action: dead zone, speed, and the frame of the horizontal plane.

Sticks are read as the Gamepad API gives them: in [-1, 1], x to the right, y down.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import Scene
from pipeline.station.params import Frame, StationParams

_X, _Y, _Z = 0, 1, 2


def pushed(stick: np.ndarray, dead_zone: float) -> np.ndarray:
    """A stick (n,) without its dead zone: 0 within it, from there on proportional, of length 1 at most."""
    length = float(np.linalg.norm(stick))
    if length <= dead_zone:
        return np.zeros_like(stick)
    return stick / length * (min(length, 1.0) - dead_zone) / (1.0 - dead_zone)


def horizontal_axes(scene: Scene, view: Viewpoint, frame: Frame) -> tuple[np.ndarray, np.ndarray]:
    """Which way the left stick's up and right lead: two unit vectors (3,), world frame.

    Robot frame: up is away from the robot's base, right is the robot's right. Camera frame: up is away from
    the camera, right is the picture's right, both in the horizontal plane.
    """
    if frame == "robot":
        front = math.radians(scene.params.camera.front_deg)
        return np.array([math.cos(front), math.sin(front), 0.0]), np.array(
            [math.sin(front), -math.cos(front), 0.0]
        )
    _, rotation = camera_to_world(scene.params.camera, view)
    away = -rotation[:, 2] * [1.0, 1.0, 0.0]
    return away / np.linalg.norm(away), rotation[:, 0]


class Sticks:
    """How sticks move the tip in one scene, seen from one view.

    Args:
        scene: whose axes are free; a push along another one does nothing.
        view: where the camera stands.
        params: section ``station``.
    """

    def __init__(self, scene: Scene, view: Viewpoint, params: StationParams) -> None:
        up, right = horizontal_axes(scene, view, params.frame)
        # columns: left stick's x, left stick's y, right stick's y
        self.to_world = np.stack([right, -up, [0.0, 0.0, -1.0]], axis=1)
        self._axes, self._dead_zone = list(scene.axes), params.dead_zone
        self._share = params.speed_m_s / params.frames_per_second / scene.params.displacement_m

    def action(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """An action (scene.action_size,), shares of the largest displacement, from two sticks (2,)."""
        level = pushed(np.asarray(left, float), self._dead_zone)
        height = pushed(np.asarray(right, float)[1:], self._dead_zone)
        velocity = self.to_world @ np.concatenate([level, height])
        return np.asarray(np.clip(velocity[self._axes] * self._share, -1.0, 1.0))


def pushes(to_world: np.ndarray, velocity: np.ndarray, dead_zone: float) -> tuple[np.ndarray, np.ndarray]:
    """The sticks, left (2,) and right (2,), that ask for a velocity: the inverse of :class:`Sticks`.

    Args:
        to_world: :attr:`Sticks.to_world`.
        velocity: shape (3,), shares of the speed of a full stick.
        dead_zone: share of a stick's travel.
    """
    wanted = to_world.T @ velocity
    return _with_dead_zone(wanted[:2], dead_zone), np.array([0.0, *_with_dead_zone(wanted[2:], dead_zone)])


def _with_dead_zone(wanted: np.ndarray, dead_zone: float) -> np.ndarray:
    length = float(np.linalg.norm(wanted))
    if length < 1e-9:
        return np.zeros_like(wanted)
    return wanted / length * (dead_zone + min(length, 1.0) * (1.0 - dead_zone))
