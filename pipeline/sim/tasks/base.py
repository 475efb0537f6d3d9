"""What a task is: an error between a point and a target, and who draws, moves and masters them.

Everything that needs to know what an episode is about asks here. The reward is minus the error, paper
eq. (1), whatever the task, so that returns, anchors and rankings mean the same for all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import mujoco
import numpy as np

from pipeline.contract.params import Section
from pipeline.sim.tasks.bodies import add_marker
from pipeline.sim.units import AXES

if TYPE_CHECKING:
    from pipeline.sim.params import SceneParams


@dataclass(frozen=True, eq=False)
class State:
    """What an expert knows of n worlds; all shapes (n, 3), m.

    Attributes:
        tip_m: where the tip is.
        point_m: where the point is that shall come to the target: the tip itself or, say, a puck.
        target_m: where the target is.
        next_target_m: where it will be a frame later.
    """

    tip_m: np.ndarray
    point_m: np.ndarray
    target_m: np.ndarray
    next_target_m: np.ndarray


class Task(Section):
    """A task as params.yaml declares it; what stands here is a resting target that the tip is to reach.

    Class attributes:
        site: the model's site whose place is :attr:`State.point_m`.
        drawn_size: how many numbers are drawn of an episode beside its start and target.
        own_arrays: whether rollouts have to hold the target's path and the error, because start, tip and a
            resting target do not tell them.
        moves: whether the target moves within an episode.
    """

    site: ClassVar[str] = "tip"
    drawn_size: ClassVar[int] = 0
    own_arrays: ClassVar[bool] = True
    moves: ClassVar[bool] = False

    @property
    def offset_m(self) -> np.ndarray:
        """From the target to where the point shall come, shape (3,), m."""
        return np.zeros(3)

    @property
    def counted(self) -> np.ndarray:
        """1 for each axis on which a distance counts, else 0: shape (3,)."""
        return np.ones(3)

    def check(self, scene: SceneParams) -> None:
        """Raises ValueError where the task and its scene do not fit together."""
        self.within_workspace(scene, np.zeros(3))

    def within_workspace(self, scene: SceneParams, reach_m: np.ndarray) -> None:
        """Raises ValueError where a goal, or what lies ± ``reach_m`` (3,) from it, leaves the workspace."""
        jitter_m, low_m, high_m = scene.target.jitter_m, scene.workspace.low_m, scene.workspace.high_m
        for candidate in scene.target.candidates_m:
            for i in (AXES.index(axis) for axis in scene.axes):
                goal, around = candidate[i] + self.offset_m[i], jitter_m[i] + reach_m[i]
                if goal - around < low_m[i] - 1e-9 or goal + around > high_m[i] + 1e-9:
                    raise ValueError(
                        f"target candidate {candidate} with jitter {jitter_m}{self.moved(i, reach_m)} "
                        f"leaves the workspace [{low_m[i]}, {high_m[i]}] m on axis {AXES[i]}"
                    )

    def moved(self, axis: int, reach_m: np.ndarray) -> str:
        """How, in the words of params.yaml, an axis of the goal differs from its target's candidate."""
        parts = [f"the task's {value:+g} m" for value in (self.offset_m[axis],) if value]
        parts += [f"the task's ± {value:g} m" for value in (reach_m[axis],) if value]
        return "".join(f" and {part}" for part in parts)

    def add_bodies(self, spec: mujoco.MjSpec, scene: SceneParams) -> None:
        """Adds the target, a mocap body of geoms in the target's group, and what else the task is about."""
        add_marker(spec, scene.target.candidates_m[0], scene.target.radius_m)

    def extent_m(self, scene: SceneParams) -> float:
        """How far from the target's place the target's geoms reach at most."""
        return scene.target.radius_m

    def draw(
        self, scene: SceneParams, start_m: np.ndarray, target_m: np.ndarray, rng: np.random.Generator
    ) -> np.ndarray:
        """What episodes (n, 3), (n, 3) begin with beside start and target: (n, drawn_size)."""
        return np.zeros((len(start_m), self.drawn_size))

    def acceptable(self, start_m: np.ndarray, target_m: np.ndarray, drawn: np.ndarray) -> np.ndarray:
        """Which draws may stand: (n,)."""
        return np.ones(len(start_m), bool)

    def targets(self, scene: SceneParams, target_m: np.ndarray, drawn: np.ndarray) -> np.ndarray:
        """Where targets (n, 3) are at the start and after each of t frames: (n, t + 1, 3), m."""
        return np.broadcast_to(target_m[:, None], (len(target_m), scene.frames + 1, 3))

    def begin(self, model: mujoco.MjModel, fields: dict[str, np.ndarray], drawn: np.ndarray) -> None:
        """Brings what else the task is about to its start, in the fields of n simulations."""

    def gap(self, point_m: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """How far points are from where they shall come, on the axes that count: (…, 3), m."""
        return (point_m - (target_m + self.offset_m)) * self.counted

    def error(self, point_m: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """The distance that the reward counts, paper eq. (1): shapes (…, 3), (…, 3) → (…), m."""
        return np.asarray(np.linalg.norm(self.gap(point_m, target_m), axis=-1))

    def succeeded(self, error_m: np.ndarray, near_m: float) -> np.ndarray:
        """At which times of errors (n, t) the task is done to within ``near_m``: (n, t)."""
        return np.asarray(error_m < near_m)

    def aim(self, state: State) -> np.ndarray:
        """Where the tip should go, an obstacle apart: (n, 3), m. Where no distance counts it stays."""
        goal = state.target_m + self.offset_m
        return np.where(self.counted > 0, goal, state.tip_m)

    def imagined(self, drawn: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        """Where one who sees nothing believes the point to be, as its tip (n, 3) moves; one call a frame.

        Args:
            drawn: of many episodes, all that is known of the one at hand: (m, drawn_size).
        """
        return lambda tip_m: tip_m
