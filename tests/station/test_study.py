"""The study's folder: codes, layout, what a kill leaves, and leaving it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.station import durable
from pipeline.station.__main__ import main
from pipeline.station.study import Study, checked_code
from pipeline.study.records import CODE

NO_CODES = (
    *("../abc", "abc/..", "..", "", "abcdefg", "abcde", "ABCDEF", "abc de", "abcde0", "abcdel"),
    *("abcde\n", "sub-abcdef", "%2e%2e2", "*23456", "abcde\u0455"),
)


@pytest.mark.parametrize("code", NO_CODES)
def test_what_is_no_code_is_refused_before_it_becomes_a_path(code: str, tmp_path: Path) -> None:
    study = Study(tmp_path / "study")
    (tmp_path / "sub-x").mkdir()
    for ask in (checked_code, study.withdraw, study.plan, study.beh):
        with pytest.raises(BelvedereError, match="participant code"):
            ask(code)
    assert (tmp_path / "sub-x").is_dir()


def test_codes_are_codes_and_differ(tmp_path: Path) -> None:
    study = Study(tmp_path)
    codes = {study.new_code() for _ in range(200)}
    assert len(codes) == 200 and all(re.fullmatch(CODE, code) for code in codes)


def test_a_withdrawn_participant_is_nowhere_and_the_others_stay(tmp_path: Path) -> None:
    study = Study(tmp_path / "study")
    codes = ["aaaaaa", "bbbbbb"]
    for code in codes:
        study.register(code, "person")
        study.beh(code).mkdir(parents=True)
        (study.beh(code) / f"{study.stem(code)}_trials.jsonl").write_text("x\n", encoding="utf-8")
        (study.folder / f"sub-{code}.dvc").write_text("outs:\n", encoding="utf-8")
    main(["withdraw", "aaaaaa", "--study", str(study.folder)])
    left = [path for path in study.folder.rglob("*") if "aaaaaa" in str(path)]
    assert not left and study.codes() == ["bbbbbb"]
    assert [row["participant_id"] for row in study.participants()] == ["sub-bbbbbb"]
    files = [path for path in study.folder.rglob("*") if path.is_file()]
    assert "aaaaaa" not in "".join(path.read_text(encoding="utf-8") for path in files)
    with pytest.raises(BelvedereError, match="is not in"):
        main(["withdraw", "aaaaaa", "--study", str(study.folder)])


def test_a_person_is_registered_once(tmp_path: Path) -> None:
    study = Study(tmp_path)
    for _ in range(3):
        study.register("aaaaaa", "person")
    assert len(study.participants()) == 1


@pytest.mark.parametrize("first, second", [("person", "scripted"), ("scripted", "person")])
def test_people_and_the_scripted_operator_are_never_mixed(first: str, second: str, tmp_path: Path) -> None:
    study = Study(tmp_path)
    study.require_kind(first), study.require_kind(second)
    study.register("aaaaaa", first)
    study.require_kind(first)
    with pytest.raises(BelvedereError, match="never mixed"):
        study.require_kind(second)


def test_two_stations_do_not_share_a_folder(tmp_path: Path) -> None:
    study = Study(tmp_path)
    with study.alone(), pytest.raises(BelvedereError, match="in use"), Study(tmp_path).alone():
        pass
    with study.alone():
        pass


def test_a_line_that_was_cut_off_is_dropped_and_the_ones_before_it_stay(tmp_path: Path) -> None:
    path = tmp_path / "lines.jsonl"
    written = [json.dumps({"n": n, "text": "ü\u2028"}, ensure_ascii=False) for n in range(3)]
    for line in written:
        durable.append_line(path, line)
    whole = path.read_bytes()
    for cut in range(1, len(written[2].encode()) + 1):
        path.write_bytes(whole[:-cut])
        assert durable.whole_lines(path) == written[:2]
        durable.append_line(path, written[2])
        assert path.read_bytes() == whole


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "plan.json"
    durable.write_json(path, {"n": 1})
    with pytest.raises(ValueError):
        durable.write_json(path, {"n": float("nan")})

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(OSError):
        durable.write_json(path, {"n": 2})
    assert json.loads(path.read_text(encoding="utf-8")) == {"n": 1}


def test_git_takes_nothing_of_a_participant_by_accident(tmp_path: Path) -> None:
    import subprocess

    from tests.support import ROOT

    taken = "data/study/sub-aaaaaa/beh/sub-aaaaaa_ses-01_trials.jsonl", "data/study/participants.tsv"
    for name in (*taken, "data/demonstration/participants.tsv"):
        assert subprocess.run(["git", "check-ignore", "-q", name], cwd=ROOT).returncode == 0
    for name in ("data/study/sub-aaaaaa.dvc", "data/study/README", "data/study/dataset_description.json"):
        assert subprocess.run(["git", "check-ignore", "-q", "--no-index", name], cwd=ROOT).returncode == 1


@pytest.mark.parametrize(
    "words, why",
    [
        (["resume"], "CODE"),
        (["withdraw", "../x"], "participant code"),
        (["resume", "aaaaaa"], "no plan"),
        (["aaaaaa"], "invalid choice"),
        (["--port", "70000"], "--port"),
        (["--seed", "-1"], "--seed"),
        (["--operator", "nobody"], "invalid choice"),
        (["--scene", "moon"], "moon"),
        (["--scene", "panda_1dof", "--views", "panda_2dof-a"], "panda_2dof-a"),
    ],
)
def test_what_is_asked_wrongly_is_told_in_a_sentence(words: list[str], why: str, tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match=re.escape(why)) as told:
        main([*words, "--study", str(tmp_path / "study")])
    assert "\n" not in str(told.value)
