"""One attempt at a trial, control frame by control frame: what moves the arm, and what is measured.

It knows neither threads nor the clock: whoever drives it says what time it is.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pipeline.station.inputs import Push, Taken
from pipeline.station.sticks import Sticks
from pipeline.station.world import World

GRASPED, TIMEOUT, ABORTED = "grasped", "timeout", "aborted"
_HOME_WITHIN_S = 5.0
COLUMNS = (
    *("t_s", "wall_s", "tip_x_m", "tip_y_m", "tip_z_m"),
    *("action_x", "action_y", "action_z", "gripper"),
)


@dataclass(frozen=True, eq=False)
class Measured:
    """An attempt that has ended.

    Attributes:
        outcome: ``grasped``, ``timeout`` or ``aborted``.
        time_s, wall_s: from the first input to A, simulated and by the clock; None without A.
        tip_m, target_m: shape (3,), when A was pressed or the attempt ended otherwise.
        distance_m: between the two at A; None without A.
        path_m: length of the tip's path.
        inputs: messages that moved.
        touched: whether the closing fingers reached the target.
        source, device: what was used; None where nothing was.
        real_time_factor: simulated seconds a second; None before a second frame.
        frames: control frames.
        rows: shape (frames, 9), columns :data:`COLUMNS`.
    """

    outcome: str
    time_s: float | None
    wall_s: float | None
    tip_m: np.ndarray
    target_m: np.ndarray
    distance_m: float | None
    path_m: float
    inputs: int
    touched: bool
    source: str | None
    device: str | None
    real_time_factor: float | None
    frames: int
    rows: np.ndarray


@dataclass
class _Marks:
    """What happened so far."""

    released: bool = False  # the sticks, since the attempt began
    first_s: float | None = None  # the clock at the first input
    first_frame: int = 0
    returning_until: int | None = None  # frame at which the way home is given up
    inputs: int = 0
    source: Push | None = None
    path_m: float = 0.0
    frame: int = 0
    begun_s: float | None = None
    rows: list[tuple[float, ...]] = field(default_factory=list)


class Attempt:
    """A world, its sticks, and the measuring.

    The sticks move nothing before they were once let go, so that a push that is left over from the trial
    before does not count. A ends the attempt from the first input on; Start leads the arm back to where it
    began.

    Args:
        world: stands at the attempt's start.
        sticks: how they move the tip.
        frame_s: length of a control frame.
        limit_s: after so long from the first input it is a timeout; None for practice.
    """

    def __init__(self, world: World, sticks: Sticks, frame_s: float, limit_s: float | None) -> None:
        self.world = world
        self.measured: Measured | None = None
        self._sticks, self._frame_s, self._limit_s = sticks, frame_s, limit_s
        self._marks = _Marks()

    @property
    def begun(self) -> bool:
        """Whether there was an input: only then is it an attempt."""
        return self._marks.first_s is not None

    @property
    def frame(self) -> int:
        """Control frames so far."""
        return self._marks.frame

    def advance(self, taken: Taken, now_s: float) -> None:
        """One control frame on.

        Args:
            taken: what the hands did since the last frame.
            now_s: the clock.
        """
        marks = self._marks
        marks.begun_s = now_s if marks.begun_s is None else marks.begun_s
        if self.measured is None:
            self._hear(taken, now_s)
        action = np.zeros(self.world.scene.action_size)
        if self.measured is None:
            action = self._action(taken.now)
            self._note(action, now_s)
        before = self.world.tip
        self.world.step(action)
        if self.measured is None:
            marks.path_m += float(np.linalg.norm(self.world.tip - before))
            marks.frame += 1

    def abort(self, now_s: float) -> None:
        """Ends it without A, if it has not ended."""
        if self.measured is None:
            self._end(ABORTED, None, now_s)

    def _hear(self, taken: Taken, now_s: float) -> None:
        marks = self._marks
        for push in taken.pushes:
            if not self._sticks.action(push.left, push.right).any():
                marks.released = True
            elif marks.released and marks.returning_until is None:
                self._moved(push)
        for name, at_s in taken.buttons:
            if name == "start" and marks.first_s is not None:
                marks.returning_until = marks.frame + round(_HOME_WITHIN_S / self._frame_s)
            if name == "a" and marks.first_s is not None:
                self._end(GRASPED, at_s, now_s)
                self.world.close()
                return
        if self._limit_s is not None and self._time_s() >= self._limit_s:
            self._end(TIMEOUT, None, now_s)

    def _moved(self, push: Push) -> None:
        marks = self._marks
        marks.inputs += 1
        marks.source = push
        if marks.first_s is None:
            marks.first_s, marks.first_frame = push.at_s, marks.frame

    def _action(self, push: Push) -> np.ndarray:
        marks = self._marks
        if marks.returning_until is not None:
            home = self.world.homeward()
            if home is not None and marks.frame < marks.returning_until:
                return home
            marks.returning_until, marks.released = None, False
        if not marks.released or marks.first_s is None:
            return np.zeros(self.world.scene.action_size)
        return self._sticks.action(push.left, push.right)

    def _note(self, action: np.ndarray, now_s: float) -> None:
        marks, wide = self._marks, np.zeros(3)
        wide[list(self.world.scene.axes)] = action
        wall_s = now_s - (marks.begun_s or now_s)
        marks.rows.append((marks.frame * self._frame_s, wall_s, *self.world.tip, *wide, 0.0))

    def _time_s(self) -> float:
        """Simulated, since the first input; 0 before it."""
        marks = self._marks
        return 0.0 if marks.first_s is None else (marks.frame - marks.first_frame) * self._frame_s

    def _end(self, outcome: str, pressed_s: float | None, now_s: float) -> None:
        marks, tip, target = self._marks, self.world.tip, self.world.target
        grasped = outcome == GRASPED
        spent_s = now_s - (now_s if marks.begun_s is None else marks.begun_s)
        used = marks.source
        wide = (0.0, 0.0, 0.0)
        marks.rows.append((marks.frame * self._frame_s, spent_s, *tip, *wide, float(grasped)))
        self.measured = Measured(
            outcome=outcome,
            time_s=self._time_s() if grasped else None,
            wall_s=max(pressed_s - marks.first_s, 0.0) if pressed_s and marks.first_s else None,
            tip_m=tip,
            target_m=target,
            distance_m=float(np.linalg.norm(tip - target)) if grasped else None,
            path_m=marks.path_m,
            inputs=marks.inputs,
            touched=grasped and self.world.touches,
            source=used.source if used else None,
            device=used.device if used else None,
            real_time_factor=marks.frame * self._frame_s / spent_s if spent_s > 0 else None,
            frames=marks.frame,
            rows=np.array(marks.rows),
        )
