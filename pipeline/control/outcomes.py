"""How episodes ended, one row each; the episodes kept for evaluation; their provenance."""

from __future__ import annotations

import platform
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np
import polars as pl

from pipeline.contract import seeds
from pipeline.contract.machine import processor
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.tasks.base import Task

NEAR_M = {"2cm": 0.02, "5cm": 0.05}


def evaluation_episodes(scene: Scene, count: int, seed: int, repeat: int) -> Episodes:
    """The held-out episodes of a repeat: the same for every viewpoint and anchor, used for nothing else."""
    return draw_episodes(scene, count, seeds.generator(seed, repeat, seeds.Stream.EVALUATION_EPISODES))


def outcomes(
    repeat: int, task: Task, episodes: Episodes, error_m: np.ndarray, reward: np.ndarray
) -> pl.DataFrame:
    """One row per episode.

    Args:
        repeat: which repeat.
        task: says when an error is a success.
        episodes: n episodes.
        error_m: what the reward counts, at the start and after each frame, shape (n, t + 1).
        reward: paper eq. (1), shape (n, t).

    Returns:
        Columns ``repeat``, ``episode``, ``return`` (paper eq. (2), m), ``final_distance_m`` (the last error),
        whether (``within_2cm``, ``within_5cm``) and after how many frames (``frames_to_…``, null if never)
        the task was first done to within so much, and the coordinates of start and target.
    """
    columns: dict[str, Any] = {
        "repeat": np.full(len(episodes), repeat),
        "episode": np.arange(len(episodes)),
        "return": reward.sum(axis=1),
        "final_distance_m": error_m[:, -1],
    }
    for name, near_m in NEAR_M.items():
        near = task.succeeded(error_m, near_m)
        came = np.asarray(near.any(axis=1))
        columns[f"within_{name}"] = came
        columns[f"frames_to_{name}"] = [
            int(f) if c else None for f, c in zip(near.argmax(axis=1), came, strict=True)
        ]
    for place, points in (("start", episodes.start_m), ("target", episodes.target_m)):
        columns |= {f"{place}_{axis}_m": points[:, i] for i, axis in enumerate("xyz")}
    return pl.DataFrame(columns, schema_overrides={f"frames_to_{name}": pl.Int64 for name in NEAR_M})


def means(table: pl.DataFrame, numbers: Callable[[pl.DataFrame], dict[str, Any]]) -> dict[str, Any]:
    """What ``numbers`` says of all rows, as ``…_mean``, and of each repeat, under ``repeats``."""
    by_repeat = table.partition_by("repeat", maintain_order=True)
    overall = {f"{name}_mean": value for name, value in numbers(table).items()}
    return {**overall, "repeats": [{"repeat": int(rows["repeat"][0]), **numbers(rows)} for rows in by_repeat]}


def provenance(compute: dict[str, Any]) -> dict[str, Any]:
    """What decides the last bits of an evaluation: ``compute`` (device, dtype), versions, machine."""
    packages = {name: version(name.replace("_", "-")) for name in ("torch", "mujoco", "mujoco_warp")}
    machine = f"{platform.machine()} {processor()}"
    return {**compute, "python": platform.python_version(), **packages, "machine": machine}
