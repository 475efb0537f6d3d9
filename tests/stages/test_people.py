"""Stages trials and people on made-up sessions: tables, aggregates, and no person in what goes into git."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from scipy import stats

from pipeline import people, trials
from pipeline.contract.errors import BelvedereError
from tests.stages.report_rankings import ranking
from tests.stages.report_study import VIEWS
from tests.study.sessions import Law, line, write_lines, write_participants, write_sessions
from tests.support import ROOT

SUBJECTS = ROOT / "data/reference/subjects.csv"


@pytest.fixture(autouse=True)
def place(workplace: Path) -> Path:
    shutil.copy(ROOT / "params.yaml", "params.yaml")
    shutil.copytree(ROOT / "data/study", "study")
    Path("rankings").mkdir()
    return workplace


def join() -> pl.DataFrame:
    trials.main(study=Path("study"), out=Path("trials.parquet"), excluded=Path("excluded.csv"))
    return pl.read_parquet("trials.parquet")


def analyse() -> dict[str, Any]:
    paths = {"trials": "trials.parquet", "rankings": "rankings", "out": "people.json", "points": "points"}
    people.main(subjects=SUBJECTS, **{name: Path(path) for name, path in paths.items()})
    return json.loads(Path("people.json").read_text(encoding="utf-8"))


def test_nobody_leaves_the_published_table_alone() -> None:
    assert len(join()) == 0
    found = analyse()
    assert found["own"] is None and found["tests"] == found["learning"] == found["course"] == []
    assert [row["source"] for row in found["rows"]] == ["Liu et al."] * 6
    assert [row["people"] for row in found["rows"]] == [11] * 6


def test_all_sessions_are_joined_and_what_does_not_count_is_listed_with_its_reason() -> None:
    write_sessions(Path("study"), people=9, seed=2, operator="person")
    table = join()
    assert len(table) == 9 * 24
    left_out = pl.read_csv("excluded.csv")
    outcome, late = pl.col("outcome") == "timeout", pl.col("latency_ms_p95") > 100
    assert len(left_out) == len(table.filter(outcome | late)) > 0
    assert set(left_out["reasons"].to_list()) == {"timeout", "latency above the limit"}
    own = analyse()["own"]
    assert own["counted"] == 9 * 24 - len(left_out) and sum(own["left_out"].values()) == len(left_out)
    assert own["source"] == "own trials" and not own["synthetic"]


def test_the_analysis_is_scipys_on_the_recorded_lines() -> None:
    names = write_sessions(Path("study"), people=9, seed=2, operator="person")
    join()
    found = analyse()
    lines = [
        json.loads(text)
        for name in names
        for text in Path(f"study/{name}/beh/{name}_ses-01_trials.jsonl").read_text().splitlines()
    ]
    counted = [n for n in lines if n["outcome"] == "grasped" and n["latency_ms_p95"] <= 100]

    def means(view: str, entry: str) -> np.ndarray:
        own = {
            name: [n[entry] for n in counted if (n["participant"], n["view"]) == (name, view)]
            for name in names
        }
        return np.array([np.mean(own[name]) for name in names])

    assert len(found["tests"]) == 6
    for row in found["tests"]:
        entry, factor = ("time_s", 1) if row["measure"] == "time" else ("distance_m", 100)
        first, second = (factor * means(row[one], entry) for one in ("first", "second"))
        assert row["two_sample"]["p"] == pytest.approx(stats.ttest_ind(first, second).pvalue)
        assert row["paired"]["p"] == pytest.approx(stats.ttest_rel(first, second).pvalue)
        assert row["signed_ranks"]["p"] == pytest.approx(stats.wilcoxon(first, second).pvalue)
        assert (row["first_mean"], row["second_mean"]) == pytest.approx((first.mean(), second.mean()))
    views = {
        (r["scene"], r["first_theta"], r["first_phi"], r["second_theta"], r["second_phi"])
        for r in found["rows"]
    }
    assert len(views) == 3  # own rows name the views in the published order


def test_what_goes_into_git_holds_no_person() -> None:
    names = write_sessions(Path("study"), people=9, seed=2, operator="person")
    table = join()
    analyse()
    text = Path("people.json").read_text(encoding="utf-8")
    assert not any(name in text or name.removeprefix("sub-") in text for name in names)
    values = {f"{v:.6g}" for name in ("time_s", "distance_m") for v in table[name].drop_nulls()}
    means = pl.read_parquet("points/means.parquet")
    values |= {f"{v:.6g}" for v in [*means["time_s"], *(100 * means["distance_m"])]}
    told = {f"{v:.6g}" for v in numbers(json.loads(text))}
    assert len(values) > 400 and not values & told


def numbers(node: Any) -> list[float]:
    children = node.values() if isinstance(node, dict) else node if isinstance(node, list) else ()
    return [node] if isinstance(node, float) else [v for child in children for v in numbers(child)]


def test_learning_that_was_put_in_is_found() -> None:
    law = Law(trials=0.05, people=0.2, learning=0.08)
    write_sessions(Path("study"), people=12, seed=3, law=law)
    join()
    rows = [row for row in analyse()["learning"] if row["measure"] == "time"]
    assert len(rows) == 3
    for row in rows:
        assert row["per_trial"]["low"] < -0.08 < row["per_trial"]["high"] < 0
        assert row["per_block"]["low"] < 0 < row["per_block"]["high"]  # each block begins anew


def test_agreement_counts_own_rows_apart_from_the_published_ones() -> None:
    write_sessions(Path("study"), people=6, seed=4)
    join()
    views = VIEWS["panda_2dof"]
    content = ranking(
        "panda_2dof", views, {key: [level] * 3 for key, level in zip(views, (-3.0, -5.0), strict=True)}
    )
    Path("rankings/panda_2dof.json").write_text(json.dumps(content), encoding="utf-8")
    found = analyse()
    assert {a["source"] for a in found["agreements"]} == {"Liu et al.", "scripted operator (synthetic)"}
    assert all((a["tasks"], a["agree"]) == (1, 1) for a in found["agreements"])
    holm = {
        r["source"]: [x["p_holm"] for x in found["rows"] if x["source"] == r["source"]] for r in found["rows"]
    }
    assert holm["Liu et al."][3] == pytest.approx(6 * 0.00036)  # over the six of its source, not over twelve


def test_one_session_and_one_view_are_no_pair() -> None:
    write_participants(Path("study"), {"sub-ab2cd3": "scripted"})
    write_lines(Path("study"), "sub-ab2cd3", [line(), line(trial=2, time_s=7.0)])
    join()
    found = analyse()
    assert found["tests"] == [] and found["own"]["people"] == 1
    assert [row["per_trial"]["change"] for row in found["learning"]] == [None, None]


def test_bad_input_is_told_in_a_sentence_and_nothing_is_written() -> None:
    write_participants(Path("study"), {"sub-ab2cd3": "scripted"})
    write_lines(Path("study"), "sub-ab2cd3", ["{"])
    with pytest.raises(BelvedereError, match="line 1 is not valid"):
        join()
    assert not Path("trials.parquet").exists() and not Path("excluded.csv").exists()
    with pytest.raises(BelvedereError, match="dvc repro trials"):
        analyse()
    assert not Path("people.json").exists() and not Path("points").exists()
