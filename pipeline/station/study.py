"""A study's folder, laid out as BIDS lays out behavioural data: who took part, and who leaves."""

from __future__ import annotations

import fcntl
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pipeline.contract.errors import BelvedereError
from pipeline.station import durable
from pipeline.station.columns import DATA_README, PARTICIPANT_COLUMNS
from pipeline.station.plan import Plan
from pipeline.study.records import ALPHABET, CODE

SESSION = 1
_TRIES = 100
_DESCRIPTION = "dataset_description.json"
_COLUMNS = ("participant_id", "operator", "sessions")


def checked_code(code: str) -> str:
    """A participant code that can only be one: it becomes part of paths.

    Raises:
        BelvedereError: it is none.
    """
    if not re.fullmatch(CODE, code):
        raise BelvedereError(
            f"participant code {code!r} is not valid; a code is six characters of {ALPHABET}, as "
            "participants.tsv has them after sub-."
        )
    return code


class Study:
    """A folder of sessions.

    Args:
        folder: made where it is missing.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.folder.mkdir(parents=True, exist_ok=True)
        if not (folder / _DESCRIPTION).exists():
            durable.write_json(folder / _DESCRIPTION, _description())
        if not (folder / "README").exists():
            durable.write_text(folder / "README", DATA_README)

    @contextmanager
    def alone(self) -> Iterator[None]:
        """No other station, and no withdrawal, works in the folder meanwhile.

        Raises:
            BelvedereError: one does.
        """
        handle = os.open(self.folder, os.O_RDONLY)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield
        except BlockingIOError:
            raise BelvedereError(
                f"{self.folder} is in use by another station; end that one first, or name another folder: "
                "--study."
            ) from None
        finally:
            os.close(handle)

    def beh(self, code: str) -> Path:
        """The folder of a participant's sessions."""
        return self.folder / f"sub-{checked_code(code)}" / "beh"

    def stem(self, code: str) -> str:
        """What the names of a session's files begin with."""
        return f"sub-{checked_code(code)}_ses-{SESSION:02d}"

    def plan_path(self, code: str) -> Path:
        """Where a session's plan lies."""
        return self.beh(code) / f"{self.stem(code)}_plan.json"

    def codes(self) -> list[str]:
        """The codes of all that have a folder."""
        names = sorted(path.name.removeprefix("sub-") for path in self.folder.glob("sub-*") if path.is_dir())
        return [name for name in names if re.fullmatch(CODE, name)]

    def new_code(self) -> str:
        """A code that nobody has."""
        taken = {*self.codes(), *(row["participant_id"].removeprefix("sub-") for row in self.participants())}
        for _ in range(_TRIES):
            code = "".join(secrets.choice(ALPHABET) for _ in range(6))
            if code not in taken:
                return code
        raise BelvedereError(f"{self.folder}: no free participant code was found in {_TRIES} draws.")

    def plan(self, code: str) -> Plan:
        """A participant's plan.

        Raises:
            BelvedereError: there is none, or it is damaged.
        """
        path = self.plan_path(code)
        if not path.is_file():
            known = ", ".join(self.codes()) or "none"
            raise BelvedereError(f"participant {code} has no plan in {self.folder}; there are: {known}.")
        try:
            return Plan.model_validate_json(path.read_text(encoding="utf-8"), strict=True)
        except (ValidationError, UnicodeDecodeError) as error:
            raise BelvedereError(
                f"{path} is damaged ({str(error).splitlines()[0]}); it has to be restored."
            ) from None

    def plans(self) -> list[Plan]:
        """All plans there are."""
        return [self.plan(code) for code in self.codes() if self.plan_path(code).is_file()]

    def require_kind(self, operator: str) -> None:
        """Raises a BelvedereError where the folder holds sessions of the other kind of operator."""
        kinds = {row["operator"] for row in self.participants()} | {plan.operator for plan in self.plans()}
        if kinds - {operator}:
            raise BelvedereError(
                f"{self.folder} holds sessions of operator {sorted(kinds)[0]!r}; people's and scripted "
                "sessions are never mixed: name another folder, --study."
            )

    def participants(self) -> list[dict[str, str]]:
        """The rows of participants.tsv."""
        path = self.folder / "participants.tsv"
        if not path.exists():
            return []
        lines = path.read_text(encoding="utf-8").splitlines()
        if not lines or tuple(lines[0].split("\t")) != _COLUMNS:
            raise BelvedereError(
                f"{path} has other columns than {', '.join(_COLUMNS)}; it has to be restored."
            )
        return [dict(zip(_COLUMNS, line.split("\t"), strict=False)) for line in lines[1:] if line]

    def register(self, code: str, operator: str) -> None:
        """Adds a participant to participants.tsv, once."""
        rows = self.participants()
        if all(row["participant_id"] != f"sub-{code}" for row in rows):
            rows.append({"participant_id": f"sub-{code}", "operator": operator, "sessions": str(SESSION)})
            self._write_participants(rows)

    def _write_participants(self, rows: list[dict[str, str]]) -> None:
        lines = ["\t".join(_COLUMNS), *("\t".join(row[name] for name in _COLUMNS) for row in rows)]
        durable.write_text(self.folder / "participants.tsv", "\n".join(lines) + "\n")
        durable.write_json(self.folder / "participants.json", PARTICIPANT_COLUMNS)

    def withdraw(self, code: str) -> list[Path]:
        """Removes a participant from the folder; returns what was removed.

        Raises:
            BelvedereError: the code is none, or nobody has it.
        """
        checked_code(code)
        found = [self.folder / f"sub-{code}", self.folder / f"sub-{code}.dvc"]
        removed = [path for path in found if path.exists()]
        rows = self.participants()
        kept = [row for row in rows if row["participant_id"] != f"sub-{code}"]
        if not removed and len(kept) == len(rows):
            known = ", ".join(self.codes()) or "none"
            raise BelvedereError(f"participant {code} is not in {self.folder}; there are: {known}.")
        for path in removed:
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink()
        if len(kept) < len(rows):
            self._write_participants(kept)
            removed.append(self.folder / "participants.tsv")
        return removed


def _description() -> dict[str, Any]:
    return {
        "Name": "Belvedere teleoperation study",
        "BIDSVersion": "1.10.0",
        "DatasetType": "raw",
        "GeneratedBy": [{"Name": "belvedere station", "Version": _version()}],
    }


def _version() -> str:
    """Of the project, from pyproject.toml, where it is not installed as a package."""
    try:
        return version("belvedere")
    except ModuleNotFoundError:
        import tomllib

        project = Path(__file__).resolve().parents[2] / "pyproject.toml"
        return str(tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"])
