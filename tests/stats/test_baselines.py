"""Orders of cheap numbers beside the world model's."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from pipeline.contract.errors import BelvedereError
from pipeline.stats.baselines import BASELINES, compare


def write(folder: Path, values: dict[str, list[float]]) -> list[str]:
    keys = [f"reach-{letter}" for letter in "abcdef"[: len(next(iter(values.values())))]]
    for i, key in enumerate(keys):
        (folder / key).mkdir()
        for stage in ("geometry", "operator", "vae"):
            content = {
                b.entry: values.get(b.entry, [0.0] * len(keys))[i] for b in BASELINES if b.stage == stage
            }
            (folder / key / f"{stage}.json").write_text(json.dumps(content))
    return keys


def test_order_and_direction(tmp_path: Path) -> None:
    returns = np.array([-4.0, -1.0, -2.0, -3.0])
    seen, probe = [1.0, 4.0, 2.0, 3.0], [0.4, 0.1, 0.2, 0.3]
    keys = write(tmp_path, {"target_seen_share": seen, "probe_mlp_tip_to_target_m_mean": probe})
    found = {row["name"]: row for row in compare(tmp_path, keys, returns)}
    tau = stats.kendalltau(seen, returns)
    assert found["visible share of the target"]["tau"] == pytest.approx(tau.statistic)
    assert found["visible share of the target"]["p"] == pytest.approx(tau.pvalue)
    assert found["MLP probe of tip - target (m)"]["tau"] == pytest.approx(1.0)  # a small error serves
    assert found["target's pixels"]["tau"] is None  # all alike
    assert all(row["same_sign"] is None for row in found.values())


def test_of_two_views_there_is_a_sign(tmp_path: Path) -> None:
    keys = write(tmp_path, {"target_seen_share": [0.5, 0.9], "pan_misalignment_deg": [0.0, 90.0]})
    found = {row["name"]: row["same_sign"] for row in compare(tmp_path, keys, np.array([-1.0, -2.0]))}
    assert found["visible share of the target"] is False
    assert found["pan away from the operator's front (°)"] is True


def test_one_view_has_no_order_and_a_lacking_number_is_named(tmp_path: Path) -> None:
    keys = write(tmp_path, {"target_seen_share": [0.5, 0.9]})
    assert compare(tmp_path, keys[:1], np.array([-1.0])) == []
    (tmp_path / keys[1] / "geometry.json").write_text("{}")
    with pytest.raises(BelvedereError, match=f"dvc repro geometry@{keys[1]}"):
        compare(tmp_path, keys, np.array([-1.0, -2.0]))
