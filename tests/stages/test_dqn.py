"""The dqn stage: empty where none is trained, the same bytes twice, added repeats only."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
import yaml

from pipeline import dqn
from pipeline.contract.errors import BelvedereError
from pipeline.qlearning import judge

ROOT = Path(__file__).resolve().parents[2]
OUTS = {"out": Path("e.parquet"), "curve": Path("curve.csv"), "metrics": Path("dqn.json")}
VIEW = {"scene": "panda_1dof", "theta": 60.0, "phi": 30.0}
FRAMES, WORLDS = 6, 16


def write_params(folder: Path, repeats: int, **method: Any) -> None:
    tree = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
    tree["scenes"]["panda_1dof"]["frames"] = FRAMES
    tree["dqn"] |= {"scenes": ["panda_1dof"], "worlds": WORLDS, **method}
    sizes = {"frames": 4 * WORLDS * FRAMES, "memory": 128, "frames_per_step": 8, "target_every": 64}
    tree["budget"] = "short"
    tree["budgets"]["short"] = {"dqn": {"repeats": repeats, **sizes}, "evaluation": {"episodes": 4}}
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
    fit = judge.fit
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
