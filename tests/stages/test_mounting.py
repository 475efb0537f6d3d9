"""The stage mounting on written networks: the same episodes with the camera off its place."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pipeline import mounting
from pipeline.control.policy import parameters, save_controller
from pipeline.storage.artefacts import write_json
from tests.stages.control_stages import ACTIONS, SCENE, VIEW, write_params, write_world_model
from tests.stages.test_ranking import PROVENANCE

BLIND, UNIT_M = -6.0, 5.0


@pytest.fixture
def workplace(workplace: Path) -> Path:
    write_params(workplace)
    for repeat in range(2):
        weights = np.random.default_rng(repeat).normal(0, 3, parameters(ACTIONS))
        save_controller(workplace / f"controller/repeat_{repeat}.npz", weights)
    rows = [{"repeat": r, "no_op": -7.0, "blind": BLIND, "expert": BLIND + UNIT_M} for r in range(2)]
    write_json(Path("anchors.json"), {"scene": SCENE, "repeats": rows, "provenance": PROVENANCE})
    return workplace


def mounted(**declared: Any) -> dict[str, Any]:
    tree = yaml.safe_load(Path("params.yaml").read_text(encoding="utf-8"))
    tree["mounting"] = {"turns_deg": [], "moves_m": [], "episodes": 4, "repeats": 2} | declared
    Path("params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")
    models = write_world_model(Path(), repeats=2)
    mounting.main(
        **VIEW, **models, controller=Path("controller"), anchors=Path("anchors.json"), out=Path("m.json")
    )
    return json.loads(Path("m.json").read_text(encoding="utf-8"))


def test_a_camera_that_is_hardly_off_loses_hardly_anything_and_one_far_off_sees_another_picture(
    workplace: Path,
) -> None:
    said = mounted(turns_deg=[1e-7, 40], moves_m=[1e-9])
    assert (said["scene"], said["theta_deg"], said["phi_deg"], said["repeats"]) == (*VIEW.values(), 2)
    near = [row["change"] for row in said["offsets"] if row["turn_deg"] < 1]
    far = [row["change"] for row in said["offsets"] if row["turn_deg"] > 1]
    assert len(near) == 4 + 6 and len(far) == 4
    assert np.abs(near).max() < np.abs(far).max() / 20


def test_intervals_are_over_repeats_and_in_score(workplace: Path) -> None:
    once = mounted(turns_deg=[20])["offsets"]
    assert all(row["low"] < row["change"] < row["high"] for row in once)
    anchors = json.loads(Path("anchors.json").read_text())
    for row in anchors["repeats"]:
        row["expert"] = BLIND + 2 * UNIT_M
    write_json(Path("anchors.json"), anchors)
    half = mounted(turns_deg=[20])["offsets"]
    assert [row["change"] for row in half] == pytest.approx([row["change"] / 2 for row in once])


def test_the_same_inputs_give_the_same_bytes(workplace: Path) -> None:
    mounted(turns_deg=[5])
    before = Path("m.json").read_bytes()
    mounted(turns_deg=[5])
    assert Path("m.json").read_bytes() == before


def test_no_offset_tilts_the_camera_over_the_zenith(workplace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(VIEW, "phi", 70.0)
    assert {row["phi_deg"] for row in mounted(turns_deg=[30])["offsets"]} == {0.0, -30.0}
