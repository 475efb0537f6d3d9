"""From what an attempt measured to the line that is recorded of it."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from pipeline.station.attempt import ABORTED, Measured
from pipeline.station.plan import Block, Plan, PlannedTrial
from pipeline.station.recorder import now
from pipeline.station.rig import flags
from pipeline.study.records import TrialRecord


@dataclass(frozen=True)
class Shown:
    """How an attempt was shown.

    Attributes:
        started_at: when it was.
        latency_ms: median and 95th percentile.
        frames_sent: pictures.
    """

    started_at: datetime
    latency_ms: tuple[float | None, float | None] = (None, None)
    frames_sent: int = 0


def entry(
    plan: Plan, block: Block, trial: PlannedTrial, attempt: int, measured: Measured, shown: Shown
) -> TrialRecord:
    """The line of an ended attempt."""
    device = {"gamepad": "gamepad", "keyboard": "keyboard"}.get(measured.source or "")
    return TrialRecord.model_validate(
        {
            **_of_plan(plan, block, trial, attempt),
            "tip_m": tuple(map(float, measured.tip_m)),
            "outcome": measured.outcome,
            "time_s": measured.time_s,
            "wall_s": measured.wall_s,
            "distance_m": measured.distance_m,
            "path_m": measured.path_m,
            "inputs": measured.inputs,
            "touched": measured.touched,
            "input": device,
            "device": measured.device,
            "latency_ms_p50": shown.latency_ms[0],
            "latency_ms_p95": shown.latency_ms[1],
            "real_time_factor": measured.real_time_factor,
            "frames_sent": shown.frames_sent,
            "frames_dropped": max(measured.frames - shown.frames_sent, 0),
            "flags": tuple(flags(shown.latency_ms[1], measured.real_time_factor)),
            "started_at": shown.started_at,
            "ended_at": now(),
        }
    )


def lost_entry(plan: Plan, trial: int, attempt: int, began_at: datetime) -> TrialRecord:
    """The line of an attempt that began before the server was killed: nothing of it is known."""
    block, planned = next((b, t) for b in plan.blocks for t in b.trials if t.trial == trial)
    return TrialRecord.model_validate(
        {
            **_of_plan(plan, block, planned, attempt),
            "tip_m": planned.start_m,
            "outcome": ABORTED,
            **dict.fromkeys(("time_s", "wall_s", "distance_m", "input", "device")),
            **dict.fromkeys(("latency_ms_p50", "latency_ms_p95", "real_time_factor")),
            **dict.fromkeys(("path_m", "inputs", "frames_sent", "frames_dropped"), 0),
            "touched": False,
            "flags": (),
            "started_at": began_at,
            "ended_at": now(),
        }
    )


def _of_plan(plan: Plan, block: Block, trial: PlannedTrial, attempt: int) -> dict[str, object]:
    return {
        "participant": plan.participant,
        "session": plan.session,
        "operator": plan.operator,
        "trial": trial.trial,
        "attempt": attempt,
        "practice": False,
        "block": block.block,
        "scene": block.scene,
        "view": block.view,
        "theta": block.theta,
        "phi": block.phi,
        "target_index": trial.target_index,
        "start_m": trial.start_m,
        "target_m": trial.target_m,
        "frame": plan.params.frame,
        "renderer": plan.renderer.name,
        "picture": plan.renderer.size,
    }
