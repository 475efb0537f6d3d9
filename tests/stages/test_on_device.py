"""Stages controller and evaluation with all repeats in one batch on a device."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
import torch

from pipeline import controller, evaluation
from pipeline.control.device_loop import DeviceLoop
from pipeline.sim.scene import Scene
from tests.cuda.device_cases import DEVICES
from tests.stages.control_stages import VIEW, write_latents, write_params, write_probes, write_world_model

SEARCHED = {"out": Path("controller"), "curve": Path("curve.csv")}
JUDGED = {"out": Path("rows.parquet"), "metrics": Path("metrics.json"), "clip": Path("clip.webp")}


def stages(models: dict[str, Path]) -> tuple[pl.DataFrame, pl.DataFrame]:
    controller.main(**VIEW, **models, **SEARCHED)
    networks = {name: models[name] for name in ("vae", "mdnrnn")}
    evaluation.main(**VIEW, **networks, controller=SEARCHED["out"], **JUDGED)
    return pl.read_csv(SEARCHED["curve"]), pl.read_parquet(JUDGED["out"])


@pytest.mark.parametrize("device", DEVICES)
def test_they_do_what_they_do_on_the_cpu(
    device: str, workplace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the first generation: later ones may part on an error of rounding."""
    models = write_world_model(workplace, repeats=2) | write_latents(workplace, repeats=2)
    models |= write_probes(workplace)
    write_params(workplace, generations=1)
    curve, rows = stages(models)
    place, asked = torch.device(device), []

    def on_device(scene: Scene, view: Any, networks: Any, given: torch.device, threads: int) -> DeviceLoop:
        asked.append(len(networks))
        return DeviceLoop(scene, view, networks, place)

    for stage in (controller, evaluation):
        monkeypatch.setattr(stage, "closed_loops", on_device)
    monkeypatch.setenv("BELVEDERE_DEVICE", place.type)
    monkeypatch.setenv("BELVEDERE_DTYPE", "float32")
    monkeypatch.setattr(torch.backends.cudnn, "allow_tf32", False)
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(workplace / "another"))
    found = stages(models)
    assert asked == [2, 2]  # both repeats in one loop
    tolerance = 1e-4 if device == "cpu" else 1e-3
    np.testing.assert_allclose(found[0]["mean"], curve["mean"], atol=tolerance)
    # what is evaluated is the mean of a distribution that was told which candidates were the better half
    np.testing.assert_allclose(found[1]["return"], rows["return"], atol=10 * tolerance)
