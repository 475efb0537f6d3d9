"""Reading a study's folder: every line of every session, checked. docs/people.md has the layout."""

from __future__ import annotations

import csv
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from pydantic import ValidationError

from pipeline.contract.errors import BelvedereError
from pipeline.study.records import PARTICIPANT, TrialRecord

PARTICIPANTS = "participants.tsv"
_NEEDED = ("participant_id", "operator")
_OPERATORS = ("person", "scripted")


def read_study(folder: Path) -> list[TrialRecord]:
    """All ended attempts of all sessions, by participant, session and the order in which they ended.

    Raises:
        BelvedereError: the folder is missing or holds persons and scripted sessions; a participant is listed
            without a folder or the reverse; a line is not valid, not of its file, or stands twice.
    """
    if not folder.is_dir():
        raise BelvedereError(
            f"{folder} is missing; people.study in params.yaml names the study's folder "
            "(`git checkout data/study` brings the empty one)."
        )
    listed = read_participants(folder)
    _refuse_unlisted(folder, listed)
    _refuse_mixture(folder, listed)
    return [record for name, operator in sorted(listed.items()) for record in _read(folder, name, operator)]


def read_participants(folder: Path) -> dict[str, str]:
    """Who is in the study: ``person`` or ``scripted`` by participant; empty where nobody is."""
    path = folder / PARTICIPANTS
    if not path.is_file():
        return {}
    try:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines(), delimiter="\t"))
    except UnicodeDecodeError:
        raise _told(path, "it is not UTF-8 text") from None
    found: dict[str, str] = {}
    for number, row in enumerate(rows, start=2):
        name, operator = (row.get(column) or "" for column in _NEEDED)
        if not re.fullmatch(PARTICIPANT, name):
            raise _told(path, f"line {number} has the participant_id {name!r}, not sub- and a code")
        if operator not in _OPERATORS:
            raise _told(path, f"line {number} has the operator {operator!r}, not {' or '.join(_OPERATORS)}")
        if name in found:
            raise _told(path, f"{name} stands in it twice")
        found[name] = operator
    return found


def _refuse_unlisted(folder: Path, listed: Mapping[str, str]) -> None:
    there = {place.name for place in folder.glob("sub-*") if place.is_dir()}
    for name in sorted(there - listed.keys()):
        raise BelvedereError(
            f"{folder / name} is not listed in {folder / PARTICIPANTS}; restore its line there, or remove "
            "the participant by `./run station withdraw CODE`."
        )
    for name in sorted(listed.keys() - there):
        raise BelvedereError(
            f"{folder / PARTICIPANTS} lists {name}, but {folder / name} is missing; `dvc pull` brings it if "
            "it was tracked, and `./run station withdraw CODE` removes a participant everywhere."
        )


def _refuse_mixture(folder: Path, listed: Mapping[str, str]) -> None:
    of = {operator: sorted(n for n, o in listed.items() if o == operator) for operator in _OPERATORS}
    if all(of.values()):
        raise BelvedereError(
            f"{folder} holds persons ({of['person'][0]}, …) and sessions of the scripted operator "
            f"({of['scripted'][0]}, …); people and synthetic data are never mixed: move the scripted ones to "
            "a folder of their own."
        )


def _read(folder: Path, name: str, operator: str) -> Iterator[TrialRecord]:
    for path in sorted((folder / name / "beh").glob(f"{name}_ses-*_trials.jsonl")):
        session = re.fullmatch(rf"{name}_ses-(\d+)_trials\.jsonl", path.name)
        if session is None:
            raise _told(path, f"its name is not {name}_ses-NUMBER_trials.jsonl")
        yield from _session(path, {"participant": name, "session": int(session[1]), "operator": operator})


def _session(path: Path, identity: Mapping[str, object]) -> list[TrialRecord]:
    """The lines of one file, which are all of the same participant and session."""
    found: dict[tuple[int, int], TrialRecord] = {}
    done: set[int] = set()
    for number, line in enumerate(_lines(path), start=1):
        record = _record(path, number, line)
        for key, value in identity.items():
            if getattr(record, key) != value:
                raise _told(path, f"line {number} has {key} = {getattr(record, key)!r}, its place {value!r}")
        if (record.trial, record.attempt) in found:
            raise _told(path, f"line {number} is attempt {record.attempt} of trial {record.trial} again")
        if record.outcome == "grasped" and record.trial in done:
            raise _told(path, f"line {number} ends trial {record.trial}, which was done before")
        done |= {record.trial} if record.outcome == "grasped" else set()
        found[record.trial, record.attempt] = record
    return list(found.values())


def _lines(path: Path) -> list[str]:
    """The whole lines; one that a crash cut off is no ended attempt."""
    try:
        *whole, rest = path.read_text(encoding="utf-8").split("\n")
    except UnicodeDecodeError:
        raise _told(path, "it is not UTF-8 text") from None
    if rest:
        print(
            f"{path}: the last line has no end, so its attempt did not end either: left out", file=sys.stderr
        )
    return whole


def _record(path: Path, number: int, line: str) -> TrialRecord:
    try:
        return TrialRecord.model_validate_json(line, strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        value = f"{place} = {first['input']!r}: " if place else ""
        why = first["msg"].removeprefix("Value error, ")
        raise _told(path, f"line {number} is not valid ({value[:80]}{why})") from None


def _told(path: Path, fault: str) -> BelvedereError:
    return BelvedereError(
        f"{path}: {fault}; the station writes this file: restore it, or correct it by hand."
    )
