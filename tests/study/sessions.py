"""Made-up sessions in the station's format, for tests and for looking at the page: synthetic, of nobody."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.study.records import ALPHABET

View = tuple[str, float, float]  # name, θ, φ in degrees
TASKS: dict[str, tuple[View, View]] = {
    "panda_1dof": (("panda_1dof-a", 90, 45), ("panda_1dof-b", 90, 30)),
    "panda_2dof": (("panda_2dof-a", 0, 0), ("panda_2dof-b", 90, 0)),
    "panda_2dof_obstacle": (("panda_2dof_obstacle-a", 0, 0), ("panda_2dof_obstacle-b", 90, 0)),
}
BEGIN = datetime(2026, 3, 2, 9, 0, tzinfo=UTC)


@dataclass(frozen=True)
class Law:
    """How made-up people do: log-normal times and distances.

    Attributes:
        time_s, distance_m: of a trial in the better view, medians.
        times: by how much longer and farther it is in the other view.
        people, trials: standard deviations of the logarithms, between people and between trials.
        learning: share by which a trial is shorter than the one before it in its block.
    """

    time_s: float = 12.0
    distance_m: float = 0.012
    times: float = 1.6
    people: float = 0.25
    trials: float = 0.2
    learning: float = 0.03


LAW = Law()


def codes(count: int, rng: np.random.Generator) -> list[str]:
    """Participants' names; drawn from a seed here, by `secrets` in the station."""
    return ["sub-" + "".join(rng.choice(list(ALPHABET), 6)) for _ in range(count)]


def line(**changes: Any) -> dict[str, Any]:
    """One valid ended attempt, with some entries changed."""
    record: dict[str, Any] = {
        "participant": "sub-ab2cd3", "session": 1, "operator": "scripted", "trial": 1, "attempt": 1,
        "practice": False, "block": 1, "scene": "panda_2dof", "view": "panda_2dof-a", "theta": 0.0,
        "phi": 0.0, "target_index": 0, "start_m": [0.5, 0.0, 0.2], "target_m": [0.5, 0.08, 0.31],
        "tip_m": [0.5, 0.08, 0.32], "outcome": "grasped", "time_s": 8.0, "wall_s": 8.1, "distance_m": 0.01,
        "path_m": 0.2, "inputs": 90, "touched": True, "input": "gamepad", "device": "a pad",
        "latency_ms_p50": 40.0, "latency_ms_p95": 60.0, "real_time_factor": 1.0, "frames_sent": 200,
        "frames_dropped": 0, "flags": [], "frame": "robot", "renderer": "ray tracer", "picture": [640, 480],
        "started_at": "2026-03-02T09:00:00Z", "ended_at": "2026-03-02T09:00:09Z",
    }  # fmt: skip
    return record | changes


def write_lines(folder: Path, participant: str, lines: Sequence[Mapping[str, Any] | str]) -> Path:
    """A participant's one session; texts are written as they are."""
    path = folder / participant / "beh" / f"{participant}_ses-01_trials.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        "".join(f"{n if isinstance(n, str) else json.dumps(n)}\n" for n in lines), encoding="utf-8"
    )
    return path


def write_participants(folder: Path, operators: Mapping[str, str]) -> Path:
    """The list of participants."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "participants.tsv"
    rows = ["participant_id\toperator\tsessions", *(f"{n}\t{o}\t1" for n, o in operators.items())]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def write_sessions(
    folder: Path, people: int, seed: int, operator: str = "scripted", law: Law = LAW, scenes: int = 3
) -> list[str]:
    """A whole study: every task, both views in balanced order, four targets each; a trial fails now and then.

    Returns:
        The participants.
    """
    rng = np.random.default_rng(seed)
    names = codes(people, rng)
    write_participants(folder, dict.fromkeys(names, operator))
    for index, name in enumerate(names):
        write_lines(folder, name, _session(name, operator, index, law, scenes, rng))
    return names


def _session(
    name: str, operator: str, index: int, law: Law, scenes: int, rng: np.random.Generator
) -> list[dict[str, Any]]:
    own, lines, at = rng.normal(0, law.people, 2), [], BEGIN + timedelta(days=index)
    trial = block = 0
    for scene, views in list(TASKS.items())[:scenes]:
        for view in views if index % 2 == 0 else views[::-1]:
            block += 1
            good = (view[1], view[2]) in ((90, 30), (0, 0))
            for place, target in enumerate(rng.permutation(4)):
                trial += 1
                factor = (1.0 if good else law.times) * (1 - law.learning) ** place
                spread = np.exp(own + rng.normal(0, law.trials, 2)) * factor
                seconds, far = law.time_s * spread[0], law.distance_m * spread[1]
                target_m = np.array([0.5, 0.08, 0.31])
                made = line(
                    participant=name, operator=operator, trial=trial, block=block, scene=scene, view=view[0],
                    theta=float(view[1]), phi=float(view[2]), target_index=int(target), time_s=seconds,
                    wall_s=seconds, distance_m=far, target_m=target_m.tolist(),
                    tip_m=np.add(target_m, [0.0, far, 0.0]).tolist(), started_at=at.isoformat(),
                    ended_at=(at + timedelta(seconds=seconds)).isoformat(),
                )  # fmt: skip
                at += timedelta(seconds=seconds + 5)
                if rng.uniform() < 0.04:
                    lines.append(made | {"outcome": "timeout", "time_s": None, "distance_m": None})
                elif rng.uniform() < 0.04:
                    lines.append(made | {"latency_ms_p95": 140.0, "flags": ["latency"]})
                else:
                    lines.append(made)
    return lines
