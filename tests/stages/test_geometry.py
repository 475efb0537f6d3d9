"""The geometry stage on real random episodes of two views of which one is known to show more."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline import geometry
from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.progress import Progress
from pipeline.sim.exploration import roll
from pipeline.sim.params import ExplorationParams
from pipeline.sim.scene import load_scene
from pipeline.storage import zarrs


@pytest.fixture(scope="module")
def rollouts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("geometry") / "panda_2dof.json"
    process = params.section(ExplorationParams, "rollouts")
    with Progress(50, "rollouts") as progress:
        block = roll(load_scene("panda_2dof"), 12, process, np.random.default_rng(1), progress)
    zarrs.write(zarrs.place(path.with_suffix(""), 0), zarrs.ROLLOUTS, block, {})
    return path


def measured(rollouts: Path, out: Path, theta: float, phi: float) -> dict:
    geometry.main(scene="panda_2dof", theta=theta, phi=phi, rollouts=rollouts, out=out)
    return json.loads(out.read_text())


def test_front_and_side(rollouts: Path, tmp_path: Path) -> None:
    front, side = (measured(rollouts, tmp_path / "g.json", theta, 0) for theta in (0, 90))
    assert front["motion_smallest_px_per_m"] > 5 * side["motion_smallest_px_per_m"]
    assert front["motion_log_det"] > side["motion_log_det"]
    assert (front["pan_misalignment_deg"], side["pan_misalignment_deg"]) == (0, 90)
    for found in (front, side):
        assert found["tip_in_frame_share"] == found["target_in_frame_share"] == 1.0
        assert 0.3 < found["target_seen_share"] <= 1.0 and found["target_pixels"] > 9
        assert 0.0 < found["tip_seen_share"] < 1.0  # fingers stand before and in it


def test_a_view_past_the_scene_shows_nothing(rollouts: Path, tmp_path: Path) -> None:
    straight_up = measured(rollouts, tmp_path / "g.json", 0, -89)  # from below the desk
    assert straight_up["target_seen_share"] == 0 and straight_up["target_pixels"] == 0


def test_missing_rollouts_are_named(tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match="dvc repro rollouts@panda_2dof"):
        measured(tmp_path / "none.json", tmp_path / "g.json", 0, 0)
    assert not (tmp_path / "g.json").exists()
