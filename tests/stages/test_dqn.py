"""The dqn stage: empty where none is trained, the same bytes twice, added repeats only."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
import yaml
from stable_baselines3 import DQN

from pipeline import dqn
from pipeline.contract import memory
from pipeline.contract.errors import BelvedereError
from pipeline.qlearning import training
from pipeline.qlearning.params import dqn_params

ROOT = Path(__file__).resolve().parents[2]
OUTS = {"out": Path("e.parquet"), "curve": Path("curve.csv"), "metrics": Path("dqn.json")}
VIEW = {"scene": "panda_1dof", "theta": 60.0, "phi": 30.0}
FRAMES, WORLDS = 6, 16


def write_params(folder: Path, repeats: int, changed: Mapping[str, int] | None = None, **method: Any) -> None:
    """The repository's params.yaml with short trainings; ``changed`` are sizes, ``method`` section dqn's."""
    tree = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
    tree["scenes"]["panda_1dof"]["frames"] = FRAMES
    tree["dqn"] |= {"scenes": ["panda_1dof"], "worlds": WORLDS, **method}
    sizes = {"frames": 4 * WORLDS * FRAMES, "memory": 128, "frames_per_step": 8, "target_every": 64}
    tree["budget"] = "short"
    tree["budgets"]["short"] = {
        "dqn": {"repeats": repeats, **sizes, **(changed or {})},
        "evaluation": {"episodes": 4},
    }
    (folder / "params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")


def written() -> list[bytes]:
    return [path.read_bytes() for path in OUTS.values()]


def test_no_repeats_leave_empty_tables(workplace: Path) -> None:
    write_params(workplace, repeats=0)
    dqn.main(**VIEW, **OUTS)
    metrics = json.loads(OUTS["metrics"].read_text())
    assert metrics["trained"] == 0 and metrics["repeats"] == [] and metrics["return_mean"] is None
    assert pl.read_parquet(OUTS["out"]).is_empty()
    assert OUTS["curve"].read_text().strip() == "repeat,generation,frames,mean,best"


def test_a_scene_that_is_not_listed_trains_nothing(workplace: Path) -> None:
    write_params(workplace, repeats=1, scenes=["fetch_reach"])
    dqn.main(**VIEW, **OUTS)
    assert json.loads(OUTS["metrics"].read_text())["trained"] == 0


def test_twice_the_same_bytes_and_more_repeats_train_only_the_added(
    workplace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_params(workplace, repeats=1)
    dqn.main(**VIEW, **OUTS)
    once = written()
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(workplace / "another"))
    dqn.main(**VIEW, **OUTS)
    assert written() == once
    calls = []
    fit = training.fit
    monkeypatch.setattr(dqn, "fit", lambda *arguments: calls.append(1) or fit(*arguments))
    write_params(workplace, repeats=2)
    dqn.main(**VIEW, **OUTS)
    assert len(calls) == 1
    table, curve = pl.read_parquet(OUTS["out"]), pl.read_csv(OUTS["curve"])
    assert table["repeat"].to_list() == [0] * 4 + [1] * 4
    assert curve["frames"].to_list() == [(i + 1) * WORLDS * FRAMES for i in range(4)] * 2
    metrics = json.loads(OUTS["metrics"].read_text())
    assert metrics["return_mean"] == pytest.approx(table["return"].mean())
    assert metrics["replay_memory_bytes"] == 128 * (2 * 64 * 64 * 3 + 20)
    assert np.isfinite(table["expert_return"].to_numpy()).all()
    twice = written()
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(workplace / "a third"))
    monkeypatch.setenv("BELVEDERE_CORES", "2")  # now each repeat in a process of its own
    dqn.main(**VIEW, **OUTS)
    assert written() == twice and len(calls) == 1


@pytest.mark.parametrize(
    ("method", "named"),
    [({"worlds": 8}, "dqn.worlds = 8"), ({"discount": 1.5}, "dqn.discount = 1.5")],
)
def test_bad_parameters_are_named(workplace: Path, method: dict[str, Any], named: str) -> None:
    write_params(workplace, repeats=1, **method)
    with pytest.raises(BelvedereError, match=named):
        dqn.main(**VIEW, **OUTS)
    assert not OUTS["out"].exists()


@pytest.mark.parametrize(
    ("name", "value", "valid"),
    [
        ("frames_per_step", 5, "a divisor of 16"),
        ("frames_per_step", 32, "a divisor of 16"),
        ("frames", 4 * WORLDS * FRAMES + 1, "a multiple of 16"),
        ("memory", 120, "a multiple of 16"),
        ("target_every", 100, "a multiple of 16"),
    ],
)
def test_a_size_that_the_library_would_round_is_refused(
    workplace: Path, name: str, value: int, valid: str
) -> None:
    write_params(workplace, repeats=1, changed={name: value})
    with pytest.raises(BelvedereError, match=rf"short\.dqn\.{name} = {value} .* {valid}"):
        dqn.main(**VIEW, **OUTS)
    assert not OUTS["out"].exists()


@pytest.mark.parametrize("frames_per_step", [4, 16])
def test_there_are_as_many_gradient_steps_as_the_sizes_say(
    workplace: Path, monkeypatch: pytest.MonkeyPatch, frames_per_step: int
) -> None:
    write_params(workplace, repeats=1, changed={"frames_per_step": frames_per_step})
    taken: list[int] = []
    monkeypatch.setattr(DQN, "train", lambda self, gradient_steps, batch_size: taken.append(gradient_steps))
    dqn.main(**VIEW, **OUTS)
    learning = 4 * WORLDS * FRAMES - WORLDS * FRAMES  # the first episodes only fill the memory
    assert sum(taken) * frames_per_step == learning


@pytest.mark.parametrize("budget", yaml.safe_load((ROOT / "params.yaml").read_text())["budgets"])
def test_the_sizes_of_every_budget_are_kept(workplace: Path, budget: str) -> None:
    tree = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
    (workplace / "params.yaml").write_text(yaml.safe_dump(tree | {"budget": budget}), encoding="utf-8")
    for scene in tree["scenes"]:
        assert dqn_params(scene)[1].memory


def test_a_replay_memory_that_no_machine_holds_is_refused_before_anything_is_made(
    workplace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BELVEDERE_CORES", "2")
    write_params(workplace, repeats=3, changed={"frames": 96 * 10**7, "memory": 96 * 10**7})
    said = r"dqn\.memory = 960000000 transitions, in 2 .* needs 4\d,\d\d\d.* GiB .* at most \d+ fit"
    with pytest.raises(BelvedereError, match=said):
        dqn.main(**VIEW, **OUTS)
    assert {path.name for path in workplace.iterdir()} == {"params.yaml"}


def test_what_is_said_to_fit_fits_and_no_more(workplace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "available_bytes", lambda system: 10 * 2**20)

    def asked(transitions: int) -> None:
        write_params(workplace, repeats=3, changed={"frames": transitions, "memory": transitions})
        training.require_memory(*dqn_params("panda_1dof"), 2)

    with pytest.raises(BelvedereError) as told:
        asked(1600)
    found = re.search(r"at most (\d+) fit", str(told.value))
    assert found
    asked(int(found[1]))
    with pytest.raises(BelvedereError, match="BELVEDERE_CORES=1"):
        asked(int(found[1]) + WORLDS)
