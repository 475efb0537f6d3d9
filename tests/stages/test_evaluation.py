from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from PIL import Image

from pipeline import anchors, evaluation
from pipeline.contract.errors import BelvedereError
from pipeline.control.policy import parameters, save_controller
from tests.stages.control_stages import ACTIONS, SCENE, VIEW, write_params, write_world_model

OUTS = {"out": Path("rows.parquet"), "metrics": Path("metrics.json"), "clip": Path("clip.webp")}
EPISODES, REPEATS = 4, 2


@pytest.fixture
def workplace(workplace: Path) -> Path:
    write_params(workplace)
    for repeat in range(REPEATS):
        save_controller(workplace / f"controller/repeat_{repeat}.npz", np.zeros(parameters(ACTIONS)))
    return workplace


def test_evaluation_and_anchors_judge_by_the_same_episodes(workplace: Path) -> None:
    """A controller of zeros stands still: it earns what no-op earns, episode by episode."""
    models = write_world_model(workplace, repeats=REPEATS)
    evaluation.main(**VIEW, **models, controller=Path("controller"), **OUTS)
    rows = pl.read_parquet(workplace / "rows.parquet")
    assert len(rows) == EPISODES * REPEATS
    metrics = json.loads((workplace / "metrics.json").read_text())
    assert (metrics["scene"], metrics["theta_deg"], metrics["phi_deg"]) == tuple(VIEW.values())
    assert metrics["return_mean"] == pytest.approx(rows["return"].mean())
    assert [one["repeat"] for one in metrics["repeats"]] == [0, 1]
    assert {"device", "dtype", "torch", "mujoco", "mujoco_warp"} <= set(metrics["provenance"])
    with Image.open(workplace / "clip.webp") as clip:
        assert clip.width == 2 * clip.height

    anchors.main(scene=SCENE, out=Path("anchors.parquet"), metrics=Path("anchors.json"))
    table = pl.read_parquet(workplace / "anchors.parquet")
    still = table.filter(pl.col("anchor") == "no_op")
    assert still.drop("anchor").equals(rows)
    levels = json.loads((workplace / "anchors.json").read_text())
    assert levels["expert_mean"] > levels["no_op_mean"]
    assert levels["repeats"][1]["no_op"] == metrics["repeats"][1]["return"]

    outputs = [workplace / name for name in (*OUTS.values(), "anchors.parquet", "anchors.json")]
    first = [path.read_bytes() for path in outputs]
    evaluation.main(**VIEW, **models, controller=Path("controller"), **OUTS)
    anchors.main(scene=SCENE, out=Path("anchors.parquet"), metrics=Path("anchors.json"))
    assert [path.read_bytes() for path in outputs] == first


def test_a_controller_that_gives_no_numbers_is_told(workplace: Path) -> None:
    models = write_world_model(workplace, repeats=REPEATS)
    save_controller(workplace / "controller/repeat_0.npz", np.full(parameters(ACTIONS), np.nan))
    with pytest.raises(BelvedereError, match="not a number"):
        evaluation.main(**VIEW, **models, controller=Path("controller"), **OUTS)
    assert not any((workplace / name).exists() for name in OUTS.values())
