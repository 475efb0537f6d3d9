"""A study's folder, read whole: what is refused, and in which sentence."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.study.folder import read_study
from tests.study.sessions import line, write_lines, write_participants, write_sessions

WHO, OTHER = "sub-ab2cd3", "sub-zz9yy8"


def one(folder: Path, *lines: dict[str, Any] | str, operator: str = "scripted") -> Path:
    write_participants(folder, {WHO: operator})
    return write_lines(folder, WHO, lines)


def test_a_folder_without_participants_holds_nothing(tmp_path: Path) -> None:
    (tmp_path / "README").write_text("nobody yet")
    assert read_study(tmp_path) == []


def test_every_line_of_every_session_is_read_in_order(tmp_path: Path) -> None:
    names = write_sessions(tmp_path, people=3, seed=1)
    found = read_study(tmp_path)
    assert [r.participant for r in found] == sorted(r.participant for r in found)
    assert {r.participant for r in found} == set(names) and len(found) == 3 * 24
    written = [
        json.loads(text)
        for name in sorted(names)
        for text in (tmp_path / name / "beh" / f"{name}_ses-01_trials.jsonl").read_text().splitlines()
    ]
    assert [r.time_s for r in found] == [w["time_s"] for w in written]
    assert [list(r.tip_m) for r in found] == [w["tip_m"] for w in written]


def test_a_line_that_a_crash_cut_off_is_left_out_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = one(tmp_path, line(), line(trial=2))
    path.write_text(path.read_text() + json.dumps(line(trial=3))[:70])
    assert [r.trial for r in read_study(tmp_path)] == [1, 2]
    assert f"{path}: the last line has no end" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"time_s": -1.0}, "time_s = -1.0: Input should be greater than or equal to 0"),
        ({"time_s": "8"}, "time_s = '8'"),
        ({"time_s": None}, "a grasped trial has a time_s"),
        ({"distance_m": 0.2}, "distance_m is 0.2, but tip_m and target_m lie 0.0100 m apart"),
        ({"outcome": "done"}, "outcome = 'done'"),
        ({"practice": True}, "practice = True"),
        ({"started_at": "2026-03-02T09:00:00"}, "started_at"),
        ({"ended_at": "2026-03-02T08:00:00Z"}, "it ended"),
        ({"trial": 0}, "trial = 0"),
        ({"name": "somebody"}, "name = 'somebody': Extra inputs are not permitted"),
        ({"tip_m": [0.5, 0.08]}, "tip_m"),
        ({"participant": "sub-zz9yy8"}, "has participant = 'sub-zz9yy8', its place 'sub-ab2cd3'"),
        ({"session": 2}, "has session = 2, its place 1"),
        ({"operator": "person"}, "has operator = 'person', its place 'scripted'"),
    ],
)
def test_a_line_that_is_not_valid_is_told_with_its_place(
    tmp_path: Path, changed: dict[str, Any], says: str
) -> None:
    path = one(tmp_path, line(), line(trial=2) | changed)
    with pytest.raises(BelvedereError, match=re.escape(says)) as caught:
        read_study(tmp_path)
    told = str(caught.value)
    assert f"{path}: line 2 " in told and "\n" not in told and told.count(". ") <= 1


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"trial": 1}', '{"time_s": NaN}', "\x00"])
def test_a_broken_line_is_told(tmp_path: Path, text: str) -> None:
    path = one(tmp_path, line(), text, line(trial=2))
    with pytest.raises(BelvedereError, match=re.escape(f"{path}: line 2 is not valid")):
        read_study(tmp_path)


def test_no_attempt_counts_twice(tmp_path: Path) -> None:
    one(tmp_path, line(), line())
    with pytest.raises(BelvedereError, match="line 2 is attempt 1 of trial 1 again"):
        read_study(tmp_path)
    one(tmp_path, line(), line(attempt=2))
    with pytest.raises(BelvedereError, match="line 2 ends trial 1, which was done before"):
        read_study(tmp_path)
    one(tmp_path, line(outcome="aborted", time_s=None, distance_m=None), line(attempt=2))
    assert [r.attempt for r in read_study(tmp_path)] == [1, 2]


def test_persons_and_scripted_sessions_are_never_mixed(tmp_path: Path) -> None:
    write_participants(tmp_path, {WHO: "person", OTHER: "scripted"})
    write_lines(tmp_path, WHO, [line(operator="person")])
    write_lines(tmp_path, OTHER, [line(participant=OTHER)])
    with pytest.raises(BelvedereError, match=f"holds persons .{WHO}, ….*scripted operator .{OTHER}"):
        read_study(tmp_path)


def test_list_and_folders_name_the_same_participants(tmp_path: Path) -> None:
    write_participants(tmp_path, {WHO: "person"})
    with pytest.raises(BelvedereError, match=f"lists {WHO}, but .* is missing; `dvc pull`"):
        read_study(tmp_path)
    write_lines(tmp_path, WHO, [line(operator="person")])
    write_lines(tmp_path, OTHER, [line(participant=OTHER)])
    with pytest.raises(BelvedereError, match=rf"{OTHER} is not listed in .*participants\.tsv"):
        read_study(tmp_path)
    (tmp_path / "participants.tsv").unlink()
    with pytest.raises(BelvedereError, match=f"{WHO} is not listed"):
        read_study(tmp_path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("participant_id\toperator\n../../etc\tperson\n", "line 2 has the participant_id '../../etc'"),
        ("participant_id\toperator\nsub-ab2cd3\trobot\n", "line 2 has the operator 'robot'"),
        ("participant_id\toperator\nsub-ab2cd3\tperson\nsub-ab2cd3\tperson\n", "stands in it twice"),
        ("who,what\na,b\n", "line 2 has the participant_id ''"),
    ],
)
def test_a_list_of_participants_that_is_none_is_told(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "participants.tsv").write_text(text)
    with pytest.raises(BelvedereError, match=re.escape(says)):
        read_study(tmp_path)


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match=r"nowhere is missing; people\.study in params\.yaml"):
        read_study(tmp_path / "nowhere")
