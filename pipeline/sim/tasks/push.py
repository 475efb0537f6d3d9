"""Push: the tip is to push a puck to a goal."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, Literal

import mujoco
import numpy as np

from pipeline.contract.params import Section
from pipeline.sim.tasks.base import State, Task
from pipeline.sim.tasks.bodies import HIDDEN_GROUP, add_disc
from pipeline.sim.units import Distance, Metres, Positive

if TYPE_CHECKING:
    from pipeline.sim.params import SceneParams

PUCK = "puck"
_PUCK_RGBA = (0.15, 0.35, 0.85, 1.0)
_JOINTS = (f"{PUCK}_x", f"{PUCK}_y")
CLEAR_M = 0.02  # that the expert keeps from the puck while it goes round it
_STEP_RAD = np.radians(45)  # about the puck, that it goes at a time
_BEHIND_RAD = np.radians(30)  # from straight behind the puck, within which it pushes
_SLOWING = 0.4  # share of what is left to the goal that a frame asks for, or the puck slides past it
_CENTRING = 0.2  # share of the way to the line of the push that a frame asks for
_DONE_M = 0.01


class Puck(Section):
    """A round puck that slides on the goal's plane.

    Attributes:
        low_m: where it may start, x and y; the lower ends.
        high_m: the upper ends.
        radius_m: its own.
        half_height_m: half its height.
        mass_kg: its mass.
        friction_n: dry friction, which it slides against.
        damping_ns_per_m: viscous friction.
    """

    low_m: tuple[Metres, Metres]
    high_m: tuple[Metres, Metres]
    radius_m: Positive
    half_height_m: Positive
    mass_kg: Positive
    friction_n: Distance
    damping_ns_per_m: Distance


class Push(Task):
    """The target is a flat goal, on whose plane the puck slides; its distance from the goal counts.

    Attributes:
        tip_height_m: of the tip above that plane.
        tip_radius_m: about how thick what touches the puck is at the tip, for the expert to keep clear of it.
        puck: what is pushed.
    """

    site: ClassVar[str] = PUCK
    drawn_size: ClassVar[int] = 2  # where the puck starts, x and y, m

    kind: Literal["push"]
    tip_height_m: Positive
    tip_radius_m: Distance
    puck: Puck

    @property
    def offset_m(self) -> np.ndarray:
        return np.array([0.0, 0.0, self.tip_height_m])

    @property
    def counted(self) -> np.ndarray:
        return np.array([1.0, 1.0, 0.0])

    @property
    def contact_m(self) -> float:
        """Distance of the tip from the puck's middle where they touch."""
        return self.puck.radius_m + self.tip_radius_m

    def check(self, scene: SceneParams) -> None:
        if scene.axes != ("x", "y"):
            raise ValueError(f"task push is done in a plane: axes must be [x, y], not {list(scene.axes)}")
        if scene.obstacles:
            raise ValueError("a puck would slide through obstacles; task push takes none")
        heights = {candidate[2] for candidate in scene.target.candidates_m}
        if len(heights) > 1:
            raise ValueError(
                f"a puck slides at one height, but target.candidates_m have z of {sorted(heights)} m"
            )
        for i, axis in enumerate(scene.axes):
            low, high = self.puck.low_m[i], self.puck.high_m[i]
            if not scene.workspace.low_m[i] <= low <= high <= scene.workspace.high_m[i]:
                raise ValueError(
                    f"task.puck has no range from low_m {low} to high_m {high} m on axis {axis} within the "
                    f"workspace [{scene.workspace.low_m[i]}, {scene.workspace.high_m[i]}] m"
                )
        self.within_workspace(scene, (self.contact_m + CLEAR_M) * np.array([1.0, 1.0, 0.0]))

    def add_bodies(self, spec: mujoco.MjSpec, scene: SceneParams) -> None:
        """A flat goal, and a puck on two slide joints that count from the middle of where it may start."""
        goal_m, puck = scene.target.candidates_m[0], self.puck
        add_disc(spec, goal_m, scene.target.radius_m)
        height_m = goal_m[2] + puck.half_height_m
        body = spec.worldbody.add_body(name=PUCK, pos=[*self._middle_m, height_m], gravcomp=1.0)
        for joint, axis in zip(_JOINTS, np.eye(3), strict=False):
            body.add_joint(
                name=joint,
                type=mujoco.mjtJoint.mjJNT_SLIDE,
                axis=axis,
                damping=[puck.damping_ns_per_m, 0, 0],
                frictionloss=puck.friction_n,
            )
        body.add_geom(
            name=PUCK,
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[puck.radius_m, puck.half_height_m, 0],
            mass=puck.mass_kg,
            rgba=_PUCK_RGBA,
            contype=0,  # it is touched by what touches (robots' far links), and touches nothing itself
            conaffinity=1,
        )
        body.add_site(name=PUCK, group=HIDDEN_GROUP)

    @property
    def _middle_m(self) -> np.ndarray:
        return np.add(self.puck.low_m, self.puck.high_m) / 2

    def draw(
        self, scene: SceneParams, start_m: np.ndarray, target_m: np.ndarray, rng: np.random.Generator
    ) -> np.ndarray:
        return rng.uniform(self.puck.low_m, self.puck.high_m, (len(start_m), 2))

    def acceptable(self, start_m: np.ndarray, target_m: np.ndarray, drawn: np.ndarray) -> np.ndarray:
        """The tip does not start at the puck."""
        away_m = np.linalg.norm(start_m[:, :2] - drawn, axis=1)
        return np.asarray(away_m >= self.contact_m + CLEAR_M)

    def begin(self, model: mujoco.MjModel, fields: dict[str, np.ndarray], drawn: np.ndarray) -> None:
        for i, name in enumerate(_JOINTS):
            joint = model.joint(name)
            fields["qpos"][:, joint.qposadr[0]] = drawn[:, i] - self._middle_m[i]
            if "qvel" in fields:  # of a robot that comes from a settled state
                fields["qvel"][:, joint.dofadr[0]] = 0.0

    def aim(self, state: State) -> np.ndarray:
        """Behind the puck, seen from the goal, round it if need be; then through it to the goal."""
        aim = state.tip_m.copy()
        aim[:, :2] = push_aim(state.tip_m[:, :2], state.point_m[:, :2], state.target_m[:, :2], self.contact_m)
        return aim

    def imagined(self, drawn: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        """In the middle of where it may start, and pushed away by the tip where that comes to touch it."""
        believed = np.median(drawn, axis=0)[None]

        def carried(tip_m: np.ndarray) -> np.ndarray:
            nonlocal believed
            way = believed - tip_m[:, :2]
            away_m = np.linalg.norm(way, axis=1, keepdims=True)
            pushed = tip_m[:, :2] + way / np.maximum(away_m, 1e-9) * self.contact_m
            believed = np.where(away_m < self.contact_m, pushed, believed)
            return np.column_stack([believed, tip_m[:, 2]])

        return carried


def push_aim(tip: np.ndarray, puck: np.ndarray, goal: np.ndarray, contact_m: float) -> np.ndarray:
    """Where the tip goes to push a puck to a goal; shapes (n, 2), m."""
    left_m = np.linalg.norm(goal - puck, axis=1, keepdims=True)
    ahead = (goal - puck) / np.maximum(left_m, 1e-9)
    across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    along_m, aside_m = (((tip - puck) * axis).sum(axis=1, keepdims=True) for axis in (ahead, across))
    angle = np.arctan2(aside_m, -along_m)  # of the tip about the puck, 0 straight behind it
    apart_m = np.maximum(np.hypot(along_m, aside_m) - contact_m, 0.0)
    # a puck goes about as the tip goes, so it is pushed towards the goal and not away from the tip
    through = tip + ahead * (apart_m + _SLOWING * left_m) - across * _CENTRING * aside_m
    step = _STEP_RAD * np.minimum(apart_m / CLEAR_M, 1.0)  # first away from it, or it is dragged along
    turned = angle - np.clip(angle, -step, step)
    about = puck + (contact_m + CLEAR_M) * (across * np.sin(turned) - ahead * np.cos(turned))
    aim = np.where(np.abs(angle) < _BEHIND_RAD, through, about)
    return np.where(left_m < _DONE_M, tip, aim)
