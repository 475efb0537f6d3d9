"""One session on disk: what ended is appended, and on the disk before the next begins."""

from __future__ import annotations

import io
import json
from datetime import UTC, datetime
from typing import Any

import numpy as np
import polars as pl
from pydantic import BaseModel, ValidationError

from pipeline.contract.errors import BelvedereError
from pipeline.station import durable
from pipeline.station.attempt import ABORTED, COLUMNS
from pipeline.station.columns import EVENT_COLUMNS, TRAJECTORY_COLUMNS, TRIAL_COLUMNS
from pipeline.station.plan import Plan
from pipeline.station.study import Study
from pipeline.study.records import TrialRecord


def now() -> datetime:
    """The time, UTC."""
    return datetime.now(UTC)


class PracticeLine(BaseModel):
    """A line of ``…_practice.jsonl``: a grasp in practice, which counts for nothing."""

    practice: bool
    at: datetime
    scene: str
    view: str
    time_s: float | None
    distance_m: float | None
    path_m: float


class Recorder:
    """Appends to a session's files, and knows what stands in them.

    Args:
        study: the folder.
        code: the participant's.
    """

    def __init__(self, study: Study, code: str) -> None:
        folder, stem = study.beh(code), study.stem(code)
        self.code, self._study = code, study
        self._trials, self._events = folder / f"{stem}_trials.jsonl", folder / f"{stem}_events.jsonl"
        self._practice = folder / f"{stem}_practice.jsonl"
        self._stem, self._folder = stem, folder
        self.records = [self._record(line) for line in durable.whole_lines(self._trials)]
        self.events = [json.loads(line) for line in durable.whole_lines(self._events)]
        durable.whole_lines(self._practice)

    def _record(self, line: str) -> TrialRecord:
        try:
            return TrialRecord.model_validate_json(line, strict=True)
        except ValidationError as error:
            why = error.errors()[0]["msg"]
            raise BelvedereError(
                f"{self._trials} holds a line that is no trial ({why}): {line[:80]}…"
            ) from None

    def begin(self, plan: Plan) -> None:
        """Writes the plan, the column dictionaries and the participant's row, before anything else."""
        durable.write_json(self._study.plan_path(self.code), plan.model_dump(mode="json"))
        for name, columns in (("trials", TRIAL_COLUMNS), ("events", EVENT_COLUMNS)):
            durable.write_json(self._folder / f"{self._stem}_{name}.json", columns)
        durable.write_json(self._folder / f"{self._stem}_trajectory.json", TRAJECTORY_COLUMNS)
        self._study.register(self.code, plan.operator)

    def event(self, event: str, **values: Any) -> None:
        """Appends an event."""
        entry = {"at": now().isoformat(timespec="milliseconds"), "event": event, **values}
        durable.append_line(self._events, json.dumps(entry, ensure_ascii=False, allow_nan=False))
        self.events.append(entry)

    def attempt_began(self, trial: int, attempt: int) -> None:
        """Appends, once, that an attempt had its first input: after a kill it counts as broken off."""
        noted = [e for e in self.events if e["event"] == "attempt" and e["trial"] == trial]
        if all(e["attempt"] != attempt for e in noted):
            self.event("attempt", trial=trial, attempt=attempt)

    def practice(self, line: PracticeLine) -> None:
        """Appends a grasp in practice."""
        durable.append_line(self._practice, line.model_dump_json())

    def trial(self, record: TrialRecord, rows: np.ndarray) -> None:
        """Writes an ended attempt: its trajectory (frames, 9), then its line."""
        name = f"{self._stem}_trial-{record.trial:03d}_attempt-{record.attempt}_trajectory.parquet"
        buffer = io.BytesIO()
        pl.DataFrame(rows, schema=dict.fromkeys(COLUMNS, pl.Float64), orient="row").write_parquet(buffer)
        durable.write(self._folder / name, buffer.getvalue())
        self.line(record)

    def line(self, record: TrialRecord) -> None:
        """Appends the line of an ended attempt."""
        durable.append_line(self._trials, record.model_dump_json())
        self.records.append(record)

    def next_attempt(self, trial: int) -> int:
        """The number of the next attempt at a trial."""
        begun = [e["attempt"] for e in self.events if e["event"] == "attempt" and e["trial"] == trial]
        return 1 + max([*begun, *(r.attempt for r in self.records if r.trial == trial)], default=0)

    def finished(self) -> set[int]:
        """The numbers of the trials that need no further attempt."""
        return {record.trial for record in self.records if record.outcome != ABORTED}

    def open_attempts(self) -> list[tuple[int, int, str]]:
        """Trial, attempt and time of attempts that began and have no line: the server was killed."""
        told = {(record.trial, record.attempt) for record in self.records}
        begun = [(e["trial"], e["attempt"], e["at"]) for e in self.events if e["event"] == "attempt"]
        return [entry for entry in begun if entry[:2] not in told]

    def tlx_answered(self) -> set[tuple[str, str]]:
        """Scene and view of the blocks after which NASA-TLX was answered."""
        return {(e["scene"], e["view"]) for e in self.events if e["event"] == "tlx"}

    def has(self, event: str) -> bool:
        """Whether such an event happened."""
        return any(entry["event"] == event for entry in self.events)
