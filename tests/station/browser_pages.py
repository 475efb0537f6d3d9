"""One example of every page, as the station would send it."""

from __future__ import annotations

from typing import Any

TASK = {"scene": "panda_2dof_obstacle", "axes": ["y", "z"], "frame": "robot"}
PLACE = {"block": 2, "blocks": 6, "trial": 3, "trials": 4}
PAGES: dict[str, dict[str, Any]] = {
    "consent": {},
    "instructions": {"frame": "robot", "blocks": 6, "trials": 24, "least_s": 300, "most_s": 900},
    "gamepad": {"dead_zone": 0.12},
    "practice": {**TASK, "elapsed_s": 20, "least_s": 300, "most_s": 900},
    "ready": {**TASK, **PLACE},
    "trial": {**TASK, **PLACE},
    "feedback": {"outcome": "grasped", "time_s": 7.31, "distance_m": 0.0123},
    "paused": {"practice": False},
    "break": {"block": 2, "blocks": 6},
    "tlx": {"scene": "panda_2dof_obstacle", "block": 2, "blocks": 6},
    "thanks": {"code": "k7m2pq", "declined": False},
    "error": {"reason": "lost"},
}
STATUS = {
    "type": "status",
    "renderer": "mujoco-egl",
    "picture": [640, 480],
    "fps": 25.0,
    "latency_ms_p50": 38.2,
    "latency_ms_p95": 61.0,
    "real_time_factor": 1.0,
    "flags": ["latency"],
}
