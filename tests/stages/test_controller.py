from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipeline import controller
from pipeline.contract.errors import BelvedereError
from pipeline.control import loop
from pipeline.control.policy import load_controller
from pipeline.storage import zarrs
from tests.stages.control_stages import (
    ACTIONS,
    EPISODES,
    FRAMES,
    VIEW,
    write_latents,
    write_params,
    write_probes,
    write_world_model,
)
from tests.stores import write_store

ROOT = Path(__file__).resolve().parents[2]
OUTS = {"out": Path("controller"), "curve": Path("curve.csv")}


def test_more_repeats_evolve_only_the_added_ones(workplace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    models = write_world_model(workplace, repeats=2) | write_latents(workplace, repeats=1)
    models |= write_probes(workplace)
    write_params(workplace)
    controller.main(**VIEW, **models, **OUTS)
    first = (workplace / "controller/repeat_0.npz").read_bytes()
    curve = pl.read_csv(workplace / "curve.csv")
    assert curve.columns == ["repeat", "generation", "frames", "mean", "best"]
    assert curve["frames"].to_list() == [4 * 2 * FRAMES, 2 * 4 * 2 * FRAMES]
    calls = []
    start = loop.Loop.start
    monkeypatch.setattr(loop.Loop, "start", lambda *arguments: calls.append(1) or start(*arguments))
    write_latents(workplace, repeats=2)
    controller.main(**VIEW, **models, **OUTS)
    assert len(calls) == 2
    assert (workplace / "controller/repeat_0.npz").read_bytes() == first
    second = load_controller(workplace / "controller/repeat_1.npz", ACTIONS)
    assert (second != load_controller(workplace / "controller/repeat_0.npz", ACTIONS)).all()
    assert pl.read_csv(workplace / "curve.csv")["repeat"].to_list() == [0, 0, 1, 1]


def test_repeats_that_evolve_together_equal_those_that_evolve_one_by_one(
    workplace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    models = write_world_model(workplace, repeats=3) | write_probes(workplace)
    write_params(workplace)
    outs = {name: workplace / path for name, path in OUTS.items()}
    found = []
    for scratch, steps in (("together", (3,)), ("one by one", (1, 2, 3))):
        monkeypatch.setenv("BELVEDERE_SCRATCH", str(workplace / scratch))
        for repeats in steps:
            shutil.rmtree(workplace / "latents", ignore_errors=True)
            latents = write_latents(workplace, repeats=repeats)
            controller.main(**VIEW, **models, **latents, **OUTS)
        controllers = [outs["out"] / f"repeat_{repeat}.npz" for repeat in range(3)]
        found.append([path.read_bytes() for path in (*controllers, outs["curve"])])
    assert found[0] == found[1]


def test_a_missing_world_model_leaves_nothing_behind(workplace: Path) -> None:
    write_params(workplace)
    latents = write_latents(workplace)
    with pytest.raises(BelvedereError, match="dvc repro vae"):
        controller.main(
            **VIEW, **latents, **write_probes(workplace), vae=Path("vae"), mdnrnn=Path("mdnrnn"), **OUTS
        )
    assert not (workplace / "controller").exists()
    assert not (workplace / "curve.csv").exists()


def test_missing_latents_are_named(workplace: Path) -> None:
    write_params(workplace)
    with pytest.raises(BelvedereError, match="dvc repro latents"):
        controller.main(
            **VIEW, **write_probes(workplace), **write_world_model(workplace), latents=Path("none"), **OUTS
        )
    assert not (workplace / "controller").exists()


def test_where_the_code_tells_nothing_the_search_ends_after_one_generation(workplace: Path) -> None:
    write_params(workplace)
    models = write_world_model(workplace) | write_latents(workplace)
    controller.main(**VIEW, **models, **write_probes(workplace, sees=True), **OUTS)
    searched = pl.read_csv(workplace / "curve.csv")
    controller.main(**VIEW, **models, **write_probes(workplace, sees=False), **OUTS)
    start = pl.read_csv(workplace / "curve.csv")
    assert searched["generation"].to_list() == [0, 1]
    assert start.equals(searched.head(1))  # the same start, on the same episodes
    assert load_controller(workplace / "controller/repeat_0.npz", ACTIONS).any()


def test_missing_probes_are_named(workplace: Path) -> None:
    write_params(workplace)
    models = write_world_model(workplace) | write_latents(workplace)
    with pytest.raises(BelvedereError, match="dvc repro vae"):
        controller.main(**VIEW, **models, probes=Path("vae.json"), **OUTS)
    assert not (workplace / "controller").exists()


@pytest.mark.parametrize(("episode", "alike"), [(EPISODES - 1, True), (EPISODES - 2, False)])
def test_the_start_is_fitted_on_training_episodes_only(workplace: Path, episode: int, alike: bool) -> None:
    """The last tenth of six episodes is held out: whatever happened in it, the search is the same."""
    write_params(workplace)
    flags = write_world_model(workplace) | write_probes(workplace) | write_latents(workplace)
    controller.main(**VIEW, **flags, **OUTS)
    before = [(workplace / name).read_bytes() for name in ("controller/repeat_0.npz", "curve.csv")]
    store = zarrs.Store(flags["latents"], zarrs.LATENTS, "latents")
    arrays = {name: store.repeat(name, 0)[None] for name in zarrs.LATENTS}
    for array in arrays.values():
        array[0, episode] = np.random.default_rng(9).standard_normal(array[0, episode].shape)
    write_store(flags["latents"], zarrs.LATENTS, arrays, {})
    controller.main(**VIEW, **flags, **OUTS)
    after = [(workplace / name).read_bytes() for name in ("controller/repeat_0.npz", "curve.csv")]
    assert (before == after) is alike


@pytest.mark.slow
def test_killed_it_continues_to_the_same_bytes(workplace: Path) -> None:
    models = write_world_model(workplace) | write_latents(workplace) | write_probes(workplace)
    write_params(workplace, generations=12)
    flags = [f"--{name}={value}" for name, value in {**VIEW, **models, **OUTS}.items()]
    command = [sys.executable, "-m", "pipeline.controller", *flags]

    def start(scratch: str) -> subprocess.Popen[bytes]:
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "BELVEDERE_SCRATCH": scratch}
        return subprocess.Popen(command, cwd=workplace, env=environment)

    assert start("undisturbed").wait(timeout=300) == 0
    expected = [(workplace / name).read_bytes() for name in ("controller/repeat_0.npz", "curve.csv")]
    process = start("disturbed")
    while not list((workplace / "disturbed").rglob("search.npz")):
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not list((workplace / "disturbed").rglob("controller.npz"))
    assert start("disturbed").wait(timeout=300) == 0
    found = [(workplace / name).read_bytes() for name in ("controller/repeat_0.npz", "curve.csv")]
    assert found == expected
