"""A line of a session's ``…_trials.jsonl``, one ended attempt: the station writes it, `trials` reads it."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import AwareDatetime, Field, model_validator

from pipeline.contract.params import Section
from pipeline.contract.viewpoints import NAME

ALPHABET = "23456789abcdefghjkmnpqrstuvwxyz"  # of participant codes: no 0 and o, no 1, i and l
CODE = rf"^[{ALPHABET}]{{6}}$"
PARTICIPANT = rf"^sub-[{ALPHABET}]{{6}}$"
_SAME_M = 1e-3  # distance against tip and target, which may be rounded apart

Place = tuple[float, float, float]  # m, world frame
Count = Annotated[int, Field(ge=0)]
Number = Annotated[int, Field(ge=1)]
Amount = Annotated[float, Field(ge=0)]
Outcome = Literal["grasped", "timeout", "aborted"]
Operator = Literal["person", "scripted"]


class TrialRecord(Section):
    """An ended attempt.

    Attributes:
        participant: ``sub-`` and the code.
        session, trial, attempt: numbered from 1; trials over the whole session, attempts within a trial.
        operator: a person, or the scripted operator, whose data are synthetic.
        practice: never true in ``…_trials.jsonl``; practice has a file of its own.
        block: of trials of one scene and view, from 1.
        scene, view: names in params.yaml. theta, phi: the view's angles, degrees.
        target_index: of the scene's ``target.candidates_m``, from 0.
        start_m, target_m: where tip and target were at the start. tip_m: where the tip was at the end, which
            is when A was pressed.
        outcome: A was pressed, the limit was reached, or the attempt was broken off.
        time_s, wall_s: from the first input to A, simulated and by the clock; null without A.
        distance_m: from tip to target at A; null without A.
        path_m: length of the tip's path. inputs: messages that moved.
        touched: whether the closing fingers reached the target.
        input, device: what was used, and how the browser names it; null where nothing was used.
        latency_ms_p50, latency_ms_p95: from input to drawn picture; null where none was measured.
        real_time_factor: simulated seconds a second; null where nothing was simulated.
        frames_sent, frames_dropped: pictures.
        flags: limits of the station that were not kept.
        frame: of the left stick. renderer, picture: of the live picture, width and height in pixels.
        started_at, ended_at: UTC.
    """

    participant: Annotated[str, Field(pattern=PARTICIPANT)]
    session: Number
    operator: Operator
    trial: Number
    attempt: Number
    practice: Literal[False]
    block: Number
    scene: Annotated[str, Field(pattern=NAME)]
    view: Annotated[str, Field(pattern=NAME)]
    theta: float
    phi: float
    target_index: Count
    start_m: Place
    target_m: Place
    tip_m: Place
    outcome: Outcome
    time_s: Amount | None
    wall_s: Amount | None
    distance_m: Amount | None
    path_m: Amount
    inputs: Count
    touched: bool
    input: Literal["gamepad", "keyboard"] | None
    device: str | None
    latency_ms_p50: Amount | None
    latency_ms_p95: Amount | None
    real_time_factor: Amount | None
    frames_sent: Count
    frames_dropped: Count
    flags: tuple[Literal["latency", "real_time"], ...]
    frame: Literal["robot", "camera"]
    renderer: str
    picture: tuple[Number, Number]
    started_at: AwareDatetime
    ended_at: AwareDatetime

    @model_validator(mode="after")
    def _measured(self) -> TrialRecord:
        if self.outcome != "grasped":
            return self
        if self.time_s is None or self.distance_m is None:
            raise ValueError("a grasped trial has a time_s and a distance_m")
        apart = float(np.linalg.norm(np.subtract(self.tip_m, self.target_m)))
        if abs(apart - self.distance_m) > _SAME_M:
            raise ValueError(
                f"distance_m is {self.distance_m:g}, but tip_m and target_m lie {apart:.4f} m apart"
            )
        return self

    @model_validator(mode="after")
    def _in_order(self) -> TrialRecord:
        if self.ended_at < self.started_at:
            raise ValueError(f"it ended ({self.ended_at}) before it started ({self.started_at})")
        return self
