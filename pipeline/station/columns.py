"""What the recorded columns mean: the dictionaries that stand beside the data, as BIDS has them."""

from __future__ import annotations

from typing import Any

DATA_README = """Sessions of the teleoperation station, laid out as BIDS lays out behavioural data.

docs/station.md of the project says how sessions are recorded, what each file holds, how to track a
participant's folder with `dvc add`, and how a participant is withdrawn. Git ignores all of this folder but
this file and dataset_description.json.
"""

PARTICIPANT_COLUMNS: dict[str, Any] = {
    "participant_id": {"Description": "sub- and a code drawn at random; no name is stored anywhere"},
    "operator": {
        "Description": "who drove the arm",
        "Levels": {"person": "a participant", "scripted": "a control law; the session is synthetic"},
    },
    "sessions": {"Description": "number of sessions"},
}

_M, _S, _MS = "m", "s", "ms"


def _column(
    description: str, units: str | None = None, levels: dict[str, str] | None = None
) -> dict[str, Any]:
    more = {"Units": units} if units else {}
    return {"Description": description, **more, **({"Levels": levels} if levels else {})}


TRIAL_COLUMNS: dict[str, Any] = {
    "participant": _column("sub- and the participant's code"),
    "session": _column("number of the session, from 1"),
    "operator": _column("who drove the arm", levels=PARTICIPANT_COLUMNS["operator"]["Levels"]),
    "trial": _column("number in the session's plan, from 1"),
    "attempt": _column("number of the attempt at this trial, from 1; all but the last were broken off"),
    "practice": _column("always false here; practice has a file of its own"),
    "block": _column("number of the block, from 1: trials of one scene seen from one view"),
    "scene": _column("name in params.yaml"),
    "view": _column("name in params.yaml"),
    "theta": _column("pan of the camera", "deg"),
    "phi": _column("tilt of the camera above the horizon", "deg"),
    "target_index": _column("which of the scene's target positions, from 0"),
    "start_m": _column("the tip's place at the start: x, y, z in the world frame", _M),
    "target_m": _column("the target's centre: x, y, z in the world frame", _M),
    "tip_m": _column("the tip's place when A was pressed, or the attempt ended otherwise", _M),
    "outcome": _column(
        "how the attempt ended",
        levels={
            "grasped": "A was pressed, whether the target was met or not",
            "timeout": "the limit of time was reached",
            "aborted": "broken off: paused, page closed, server ended",
        },
    ),
    "time_s": _column("operation time, from the first input to A, simulated", _S),
    "wall_s": _column("the same by the clock of the wall", _S),
    "distance_m": _column("from tip to target's centre when A was pressed, Euclidean", _M),
    "path_m": _column("length of the tip's path", _M),
    "inputs": _column("messages of the sticks that moved a free axis"),
    "touched": _column("whether what lies between the fingers met the target's sphere when A was pressed"),
    "input": _column(
        "what was used", levels={"gamepad": "sticks", "keyboard": "keys as sticks pushed to the end"}
    ),
    "device": _column("the browser's name of the device"),
    "latency_ms_p50": _column(
        "median time from a reading of the sticks to the drawn picture that shows it", _MS
    ),
    "latency_ms_p95": _column("its 95th percentile", _MS),
    "real_time_factor": _column("simulated seconds in a second"),
    "frames_sent": _column("pictures that were sent to the page"),
    "frames_dropped": _column("control frames whose picture was overtaken by a newer one, and not sent"),
    "flags": _column(
        "limits that were not kept; the trial counts all the same",
        levels={"latency": "p95 above 100 ms", "real_time": "real-time factor below 0.98"},
    ),
    "frame": _column(
        "of the left stick",
        levels={
            "robot": "up is away from the robot's base, right is the robot's right",
            "camera": "up is away from the camera, right is the picture's right",
        },
    ),
    "renderer": _column("what drew the pictures"),
    "picture": _column("width and height", "pixels"),
    "started_at": _column("when the trial was shown, UTC"),
    "ended_at": _column("when it ended, UTC"),
}

TRAJECTORY_COLUMNS: dict[str, Any] = {
    "t_s": _column("simulated, from the beginning of the attempt", _S),
    "wall_s": _column("the same by the clock of the wall", _S),
    "tip_x_m": _column("the tip at the beginning of the frame, world frame", _M),
    "tip_y_m": _column("as tip_x_m", _M),
    "tip_z_m": _column("as tip_x_m", _M),
    "action_x": _column("commanded displacement in this frame, as a share of the scene's displacement_m"),
    "action_y": _column("as action_x"),
    "action_z": _column("as action_x"),
    "gripper": _column("1 where A was pressed, else 0"),
}

EVENT_COLUMNS: dict[str, Any] = {
    "at": _column("when, UTC"),
    "event": _column(
        "what",
        levels={
            "consent": "the text was agreed to; version and sha256 name it",
            "begin": "a station was started for the session",
            "gamepad": "the test of the gamepad was passed",
            "practice": "practice ended",
            "attempt": "an attempt began: its first input",
            "pause": "somebody paused",
            "resume": "the session went on",
            "gone": "the page was closed",
            "tlx": "answers to NASA-TLX after a block, 0 to 100",
            "end": "the session ended",
        },
    ),
}
