"""The scripted operator's control law, for any number of operators at a time.

Every ``look_s`` it looks at the way still to go, with an error. ``reaction_s`` later it moves by that look,
in proportion to the way and at most at its speed. It closes the gripper once it has believed for ``dwell_s``
to be near enough. Nothing of it is a model of people.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from pipeline.scripted.params import OperatorParams


@dataclass(frozen=True, eq=False)
class Act:
    """What operators do in a control frame.

    Attributes:
        velocity_m_s: of the tip, on the controlled axes: (n, axes).
        grasps: who has closed the gripper, now or before: (n,).
    """

    velocity_m_s: np.ndarray
    grasps: np.ndarray


class ScriptedOperator:
    """``count`` operators, each before a world of its own.

    Args:
        params: section ``operator``.
        frame_s: length of a control frame.
        count: how many.
        axes: how many axes are controlled.
        rng: of the errors of looks; every look draws (count, axes) numbers, whoever is done already.
    """

    def __init__(
        self, params: OperatorParams, frame_s: float, count: int, axes: int, rng: np.random.Generator
    ) -> None:
        self._params, self._rng, self._shape = params, rng, (count, axes)
        self._between = max(1, round(params.look_s / frame_s))
        self._dwell = max(1, round(params.dwell_s / frame_s))
        self._waiting = deque[tuple[np.ndarray, np.ndarray] | None](
            [None] * round(params.reaction_s / frame_s)
        )
        self._frame = 0
        self._looked: tuple[np.ndarray, np.ndarray] | None = None
        self._near_for = np.zeros(count, dtype=np.int64)
        self._grasps = np.zeros(count, dtype=bool)

    def act(self, way_m: np.ndarray, left_m: np.ndarray, view_m: np.ndarray | None = None) -> Act:
        """One control frame on.

        Args:
            way_m: from the tip to where it heads now, on the controlled axes: (n, axes), m. Behind an
                obstacle that is a point above it, else the target.
            left_m: from the tip to the target: (n, axes), m.
            view_m: what the view adds to the error of a look, as a factor L of its covariance L Lᵀ:
                (n, axes, axes), m; nothing where it is left out.

        Returns:
            What the operators do in this frame. Until the first look takes effect they rest.
        """
        if self._frame % self._between == 0:
            self._look(way_m, left_m, view_m)
        self._frame += 1
        self._waiting.append(self._looked)
        believed = self._waiting.popleft()
        if believed is None:
            return Act(np.zeros(self._shape), self._grasps.copy())
        way, left = believed
        near = np.linalg.norm(left, axis=1) <= self._params.grasp_within_m
        self._near_for = np.where(near, self._near_for + 1, 0)
        self._grasps |= self._near_for >= self._dwell
        return Act(self._velocity(way) * ~self._grasps[:, None], self._grasps.copy())

    def _look(self, way_m: np.ndarray, left_m: np.ndarray, view_m: np.ndarray | None) -> None:
        error = self._params.noise_m * self._rng.standard_normal(self._shape)
        seen = self._rng.standard_normal(self._shape)
        if view_m is not None:
            error = error + np.einsum("nij,nj->ni", view_m, seen)
        self._looked = np.asarray(way_m) + error, np.asarray(left_m) + error

    def _velocity(self, way_m: np.ndarray) -> np.ndarray:
        velocity = self._params.gain_per_s * way_m
        speed = np.linalg.norm(velocity, axis=1, keepdims=True)
        return np.asarray(velocity * np.minimum(1.0, self._params.speed_m_s / np.maximum(speed, 1e-12)))
