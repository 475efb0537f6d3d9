"""Controllers tried on episodes: a table of how each episode ended, and one film."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from pipeline.contract.progress import Progress
from pipeline.contract.viewpoints import Viewpoint
from pipeline.control.clip import write_clip
from pipeline.control.jobs import Job
from pipeline.control.loops import Loops
from pipeline.control.outcomes import outcomes
from pipeline.sim.draws import Episodes
from pipeline.sim.worlds import target_paths

OUTCOMES, CLIP = "outcomes.parquet", "clip.webp"


def try_out(
    loops: Loops,
    view: Viewpoint,
    controllers: Sequence[np.ndarray],
    episodes: Sequence[Episodes],
    folders: Mapping[int, Path],
) -> None:
    """Writes each repeat's ``OUTCOMES`` into its folder, and repeat 0's first episode as ``CLIP``.

    Args:
        loops: controller ``i`` sees through its networks ``i``.
        view: of the loops.
        controllers: flat weights, one of each repeat.
        episodes: on which each is tried.
        folders: of the repeats, by their numbers, in the same order.
    """
    jobs = zip(controllers, episodes, strict=True)
    traces = loops.run([Job.of(i, flat[None], own) for i, (flat, own) in enumerate(jobs)])
    what = f"evaluation {loops.scene.name} ({view.theta:g}°, {view.phi:g}°)"
    with Progress(len(folders), what) as progress:
        for (repeat, folder), own, trace in zip(folders.items(), episodes, traces, strict=True):
            rows = outcomes(repeat, loops.scene.task, own, trace.error_m, trace.reward)
            rows.write_parquet(folder / OUTCOMES)
            if repeat == 0:
                targets = target_paths(loops.scene, own[:1])[0]
                write_clip(folder / CLIP, loops.scene, view, trace.qpos[0], targets)
            progress.advance(returned=f"{trace.returns.mean():.2f}")


def numbers(rows: pl.DataFrame) -> dict[str, Any]:
    """The means of a table of outcomes that the metrics name.

    ``frames_to_5cm_where_reached`` is the mean over the episodes in which the tip came within 5 cm at all,
    whose share is ``within_5cm_share``; ``None`` where there are none.
    """
    return {
        "return": rows["return"].mean(),
        "final_distance_m": rows["final_distance_m"].mean(),
        "frames_to_5cm_where_reached": rows["frames_to_5cm"].mean(),
        **{f"within_{name}_share": rows[f"within_{name}"].mean() for name in ("2cm", "5cm")},
    }
