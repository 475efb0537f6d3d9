"""Whole sessions, driven through the real WebSocket in real time; and servers that are killed meanwhile."""

from __future__ import annotations

import json
import threading
import time
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipeline.station.attempt import COLUMNS
from pipeline.station.columns import TRIAL_COLUMNS
from pipeline.station.started import Started
from pipeline.study.records import TrialRecord
from tests.station.sessions import code_of, drive, file_of, lines_of, small_station, start


@pytest.fixture(scope="module")
def complete(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which a session was completed."""
    folder = small_station(tmp_path_factory.mktemp("complete"))
    with start(folder) as station:
        report = drive(folder, station.link)
        assert report.done, station.lines
        assert station.wait() == 0, station.lines
    return folder


def test_every_planned_trial_has_one_finished_line(complete: Path) -> None:
    plan = json.loads(file_of(complete, "plan.json").read_text(encoding="utf-8"))
    planned = {trial["trial"]: (block, trial) for block in plan["blocks"] for trial in block["trials"]}
    lines = lines_of(complete, "trials.jsonl")
    assert sorted(line["trial"] for line in lines) == sorted(planned) == [1, 2, 3, 4]
    for line in lines:
        block, trial = planned[line["trial"]]
        assert (line["scene"], line["view"], line["block"]) == (block["scene"], block["view"], block["block"])
        assert line["target_m"] == trial["target_m"] and line["start_m"] == trial["start_m"]


def test_lines_are_records_of_the_study_and_their_columns_are_explained(complete: Path) -> None:
    for text in file_of(complete, "trials.jsonl").read_text(encoding="utf-8").splitlines():
        record = TrialRecord.model_validate_json(text, strict=True)
        assert record.operator == "scripted" and record.outcome == "grasped"
        assert set(json.loads(text)) == set(TRIAL_COLUMNS)
    assert json.loads(file_of(complete, "trials.json").read_text(encoding="utf-8")) == TRIAL_COLUMNS


def test_the_operator_comes_to_the_target_and_its_time_is_that_of_the_clock(complete: Path) -> None:
    for line in lines_of(complete, "trials.jsonl"):
        assert line["distance_m"] < 0.03 and line["touched"]
        assert line["latency_ms_p50"] <= line["latency_ms_p95"]
        if line["real_time_factor"] > 0.99:
            assert line["time_s"] == pytest.approx(line["wall_s"], abs=0.1)


def test_a_trajectory_has_a_row_a_frame_and_its_path_is_the_recorded_one(complete: Path) -> None:
    for line in lines_of(complete, "trials.jsonl"):
        name = f"trial-{line['trial']:03d}_attempt-{line['attempt']}_trajectory.parquet"
        table = pl.read_parquet(file_of(complete, name))
        assert tuple(table.columns) == COLUMNS
        tips = table.select("tip_x_m", "tip_y_m", "tip_z_m").to_numpy()
        assert np.linalg.norm(np.diff(tips, axis=0), axis=1).sum() == pytest.approx(line["path_m"], abs=1e-9)
        assert tips[0] == pytest.approx(line["start_m"], abs=2e-3)
        assert tips[-1] == pytest.approx(line["tip_m"], abs=1e-12)
        assert np.diff(table["t_s"].to_numpy()) == pytest.approx(0.04, abs=1e-9)
        assert table["gripper"].to_list() == [0.0] * (len(table) - 1) + [1.0]


def test_the_folder_is_laid_out_as_bids_has_it(complete: Path) -> None:
    study, code = complete / "study", code_of(complete)
    description = json.loads((study / "dataset_description.json").read_text(encoding="utf-8"))
    assert description["Name"]
    assert (description["BIDSVersion"], description["DatasetType"]) == ("1.10.0", "raw")
    rows = (study / "participants.tsv").read_text(encoding="utf-8").splitlines()
    assert rows == ["participant_id\toperator\tsessions", f"sub-{code}\tscripted\t1"]
    columns = json.loads((study / "participants.json").read_text(encoding="utf-8"))
    assert set(columns) == set(rows[0].split("\t"))
    assert all(column["Description"] for column in columns.values())
    files = {path.name for path in (study / f"sub-{code}" / "beh").iterdir()}
    assert all(name.startswith(f"sub-{code}_ses-01_") for name in files)
    assert not [path for path in study.rglob("*") if ".part" in path.name]


def test_the_scripted_operator_may_not_join_people(complete: Path) -> None:
    from pipeline.contract.errors import BelvedereError
    from pipeline.station.study import Study

    with pytest.raises(BelvedereError, match="never mixed"):
        Study(complete / "study").require_kind("person")


@pytest.mark.parametrize("kills", [1, pytest.param(10, marks=pytest.mark.slow)])
def test_a_killed_server_loses_and_doubles_no_finished_trial(kills: int, tmp_path: Path) -> None:
    folder = small_station(tmp_path, trials=2 if kills == 1 else 14)
    rng = np.random.default_rng(kills)
    arguments: list[str] = []
    for _ in range(kills):
        before = kept(folder)
        with start(folder, *arguments) as station:
            after_s = rng.uniform(0.0, 1.0 if kills == 1 else 3.0)
            killer = threading.Thread(target=kill_later, args=(station, folder, attempts(folder), after_s))
            killer.start()
            report = drive(folder, station.link)
            killer.join()
        assert not report.done
        assert kept(folder)[: len(before)] == before
        arguments = ["resume", code_of(folder)]
    before = kept(folder)
    with start(folder, *arguments) as station:
        assert drive(folder, station.link).done, station.lines
    check_whole(folder, before)
    if kills > 1:
        assert "aborted" in "".join(kept(folder))


def kill_later(station: Started, folder: Path, had: int, after_s: float) -> None:
    """kill -9, some time after this server's first attempt began: in it, as it is recorded, or later."""
    while attempts(folder) <= had:
        time.sleep(0.005)
    time.sleep(after_s)
    station.process.kill()


def attempts(folder: Path) -> int:
    """How many attempts have begun."""
    found = list((folder / "study").glob("sub-*/beh/*_events.jsonl"))
    return found[0].read_text(encoding="utf-8").count('"event": "attempt"') if found else 0


def kept(folder: Path) -> list[str]:
    """The whole lines on disk."""
    found = list((folder / "study").glob("sub-*/beh/*_trials.jsonl"))
    text = found[0].read_text(encoding="utf-8") if found else ""
    return text[: text.rfind("\n") + 1].splitlines()


def check_whole(folder: Path, kept_before: list[str]) -> None:
    """Each planned trial is finished once; attempts at it are numbered; nothing that stood there is gone."""
    plan = json.loads(file_of(folder, "plan.json").read_text(encoding="utf-8"))
    planned = [trial["trial"] for block in plan["blocks"] for trial in block["trials"]]
    lines = lines_of(folder, "trials.jsonl")
    finished = [line["trial"] for line in lines if line["outcome"] != "aborted"]
    assert sorted(finished) == planned
    for trial in planned:
        attempts = [line for line in lines if line["trial"] == trial]
        assert [line["attempt"] for line in attempts] == list(range(1, len(attempts) + 1))
        assert [line["outcome"] == "aborted" for line in attempts] == [True] * (len(attempts) - 1) + [False]
    assert kept(folder)[: len(kept_before)] == kept_before
    begun = [(e["trial"], e["attempt"]) for e in lines_of(folder, "events.jsonl") if e["event"] == "attempt"]
    assert sorted(begun) == sorted((line["trial"], line["attempt"]) for line in lines)
