"""Do baselines without training order the views as the world model does?

Each baseline is a number per view that costs seconds; its order is held against that of the world
model's mean returns by Kendall's τ-b (M. G. Kendall, Biometrika 33 (1945) 239-251). Of two views there
is only a sign, and by chance it agrees every second time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from pipeline.contract.errors import BelvedereError
from pipeline.storage.artefacts import read_json


@dataclass(frozen=True)
class Baseline:
    """Where a number stands, and which way it should point.

    Attributes:
        name: what it is called.
        stage: whose metrics hold it.
        entry: its key there.
        better: 1 where more of it should serve, -1 where less.
    """

    name: str
    stage: str
    entry: str
    better: int


BASELINES = (
    Baseline("projected motion, weakest direction (px/m)", "geometry", "motion_smallest_px_per_m", 1),
    Baseline("projected motion, log of the area (px²/m²)", "geometry", "motion_log_det", 1),
    Baseline("visible share of the tip", "geometry", "tip_seen_share", 1),
    Baseline("visible share of the target", "geometry", "target_seen_share", 1),
    Baseline("target's pixels", "geometry", "target_pixels", 1),
    Baseline("pan away from the operator's front (°)", "geometry", "pan_misalignment_deg", -1),
    Baseline("scripted operator's time (s)", "operator", "time_s_mean", -1),
    Baseline("scripted operator's distance (m)", "operator", "distance_m_mean", -1),
    Baseline("linear probe of tip - target (m)", "vae", "probe_linear_tip_to_target_m_mean", -1),
    Baseline("MLP probe of tip - target (m)", "vae", "probe_mlp_tip_to_target_m_mean", -1),
)


@dataclass(frozen=True)
class Compared:
    """A baseline beside the world model.

    Attributes:
        name: the baseline's.
        stage: who measures it.
        values: by branch.
        tau: Kendall's τ-b with the mean returns, the baseline turned so that more should serve; ``None``
            where all its values are alike.
        p: of τ, two-sided; ``None`` with fewer than three views.
        same_sign: of two views, whether both orders agree; ``None`` otherwise.
    """

    name: str
    stage: str
    values: dict[str, float]
    tau: float | None
    p: float | None
    same_sign: bool | None


def compare(folder: Path, keys: Sequence[str], returns: np.ndarray) -> list[dict[str, Any]]:
    """All baselines of a scene's views, as plain tables.

    Args:
        folder: holds one folder per branch.
        keys: the views, in the order of ``returns``.
        returns: (view,) mean returns.

    Raises:
        BelvedereError: a file or an entry is missing.
    """
    if len(keys) < 2:
        return []
    return [asdict(_compared(b, {k: _value(folder / k, k, b) for k in keys}, returns)) for b in BASELINES]


def _value(folder: Path, key: str, baseline: Baseline) -> float:
    path, made_by = folder / f"{baseline.stage}.json", f"{baseline.stage}@{key}"
    value = read_json(path, made_by).get(baseline.entry)
    if not isinstance(value, (int, float)) or not np.isfinite(value):
        raise BelvedereError(
            f"{path}: {baseline.entry} is {value!r}, no number; `dvc repro {made_by}` makes it."
        )
    return float(value)


def _compared(baseline: Baseline, values: dict[str, float], returns: np.ndarray) -> Compared:
    served = baseline.better * np.array(list(values.values()))
    if np.ptp(served) == 0:
        return Compared(baseline.name, baseline.stage, values, None, None, None)
    found = stats.kendalltau(served, returns)
    two = len(served) == 2
    sign = bool(found.statistic > 0) if two else None
    return Compared(
        baseline.name,
        baseline.stage,
        values,
        float(found.statistic),
        None if two else float(found.pvalue),
        sign,
    )
