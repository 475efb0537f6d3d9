"""Each example of a task, put into params.yaml as docs/tasks.md says, through every stage on budget tiny."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import polars as pl
import pytest
import yaml

from pipeline import (
    anchors,
    controller,
    evaluation,
    frames,
    geometry,
    latents,
    mdnrnn,
    operator,
    ranking,
    rollouts,
    vae,
)
from pipeline.checks.parameters import check
from pipeline.sim.scene import load_scene
from pipeline.storage import zarrs
from pipeline.storage.positions import error_by_frame, target_by_frame
from tests.examples import KINDS
from tests.support import ROOT


def paste(folder: Path, kind: str) -> None:
    """The repository's params.yaml with the example's entries, of short episodes, and the budget tiny."""
    example = (ROOT / f"examples/tasks/{kind}.yaml").read_text(encoding="utf-8")
    text = (ROOT / "params.yaml").read_text(encoding="utf-8")
    for section in ("viewpoints", "scenes"):
        entries = re.search(rf"^{section}:\n((?: .*\n|\n)+)", example, re.M)
        assert entries
        shorter = entries[1].replace("frames: 50 ", "frames: 16 ").replace("frames: 50\n", "frames: 16\n")
        text, times = re.subn(rf"^{section}:\n", lambda found, own=shorter: found[0] + own, text, flags=re.M)
        assert times == 1
    assert yaml.safe_load(text)["scenes"][f"panda_{kind}"]["frames"] == 16
    text = re.sub(r"^budget: \w+", "budget: tiny", text, flags=re.M)
    text = re.sub(r"^sight_share: .*", "sight_share: 0.9999", text, flags=re.M)
    text = re.sub(r"^  limit_s: 60 ", "  limit_s: 4 ", text, flags=re.M)
    text = re.sub(r"^  trials: 16 ", "  trials: 2 ", text, flags=re.M)
    (folder / "params.yaml").write_text(text, encoding="utf-8")
    listed = {key: f"${{viewpoints.{key}}}" for key in yaml.safe_load(text)["viewpoints"]}
    stages = {"evaluation": {"foreach": {"study": "${viewpoint}", **listed}}}
    (folder / "dvc.yaml").write_text(yaml.safe_dump({"stages": stages}), encoding="utf-8")
    (folder / "data").mkdir()
    shutil.copy(ROOT / "data/allocation.yaml", folder / "data/allocation.yaml")
    check(folder / "params.yaml")


@pytest.mark.parametrize("kind", KINDS)
def test_an_example_goes_through_every_stage(workplace: Path, kind: str) -> None:
    paste(workplace, kind)
    name, views = f"panda_{kind}", [(f"panda_{kind}-{letter}", letter) for letter in "ab"]
    angles = {"a": (0.0, {"align": 20.0, "follow": 0.0, "push": 50.0}[kind])}
    angles["b"] = (90.0, {"align": 20.0, "follow": 0.0, "push": 20.0}[kind])
    said = Path("data/rollouts") / f"{name}.json"
    rollouts.main(scene=name, out=said, store=said.with_suffix(""))
    episodes = zarrs.Store(said.with_suffix(""), zarrs.ROLLOUTS, "rollouts")
    hold_rollouts(episodes, name)
    anchors.main(scene=name, out=Path("anchors.parquet"), metrics=Path(f"reports/anchors/{name}.json"))
    levels = json.loads(Path(f"reports/anchors/{name}.json").read_text(encoding="utf-8"))
    assert levels["expert_mean"] > levels["blind_mean"] > levels["no_op_mean"]
    for key, letter in views:
        branch(name, key, said, *angles[letter])
    table = Path(f"reports/rankings/{name}.csv")
    claims = ROOT / "data/reference/claims.yaml"
    ranking.main(
        scene=name,
        branches=Path(f"reports/branches/{name}"),
        anchors=Path(f"reports/anchors/{name}.json"),
        claims=claims,
        out=table.with_suffix(".json"),
        table=table,
    )
    assert sorted(pl.read_csv(table)["branch"]) == [key for key, _ in views]


def hold_rollouts(episodes: zarrs.Store, name: str) -> None:
    """Path and error are stored, and are those that the rewards count."""
    scene, reward = load_scene(name), episodes.repeat("reward", 0)
    target, error = target_by_frame(episodes, 0), error_by_frame(episodes, 0)
    np.testing.assert_allclose(np.linalg.norm(error[:, 1:], axis=2), -reward[:, :-1], atol=1e-5)
    assert bool(np.abs(np.diff(target, axis=1)).max() > 0.01) == scene.task.moves


def branch(scene: str, key: str, said: Path, theta: float, phi: float) -> None:
    """All stages of one viewpoint."""
    view, reports = {"scene": scene, "theta": theta, "phi": phi}, Path(f"reports/branches/{scene}/{key}")
    shot, coded, nets = Path("data/frames") / key, Path("data/latents") / key, Path("models")
    frames.main(branch=key, **view, rollouts=said, out=shot, picture=Path("pictures") / key)
    store = zarrs.Store(shot, zarrs.FRAMES, "frames")
    assert store.has("error") and store.has("target_path")
    assert store.repeat("target_pixels_free", 0).min() > 5  # the target is in the picture
    assert store.repeat("target_pixels", 0).max() > 5
    geometry.main(**view, rollouts=said, out=reports / "geometry.json")
    operator.main(**view, out=reports / "operator.json")
    assert (
        0.2 < json.loads((reports / "geometry.json").read_text(encoding="utf-8"))["target_seen_share"] <= 1.0
    )
    vae.main(frames=shot, out=nets / "vae" / key, metrics=reports / "vae.json", picture=Path(f"{key}.png"))
    numbers = json.loads((reports / "vae.json").read_text(encoding="utf-8"))
    assert 0.0 < numbers["guess_tip_to_target_m_mean"] < 0.5
    latents.main(frames=shot, vae=nets / "vae" / key, out=coded)
    mdnrnn.main(latents=coded, out=nets / "mdnrnn" / key, metrics=reports / "mdnrnn.json")
    models = {name: nets / name / key for name in ("vae", "mdnrnn")}
    policy = nets / "controller" / key
    controller.main(
        **view,
        probes=reports / "vae.json",
        latents=coded,
        **models,
        out=policy,
        curve=reports / "controller.csv",
    )
    evaluation.main(
        **view,
        **models,
        controller=policy,
        out=Path(f"{key}.parquet"),
        metrics=reports / "evaluation.json",
        clip=Path(f"{key}.webp"),
    )
    rows = pl.read_parquet(f"{key}.parquet")
    assert rows["return"].is_finite().all() and rows["return"].max() < 0
