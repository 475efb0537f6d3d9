"""The course of a session: instructions, gamepad, practice, blocks of trials, questions, thanks."""

from __future__ import annotations

from datetime import datetime

from pipeline.station.attempt import Attempt, Measured
from pipeline.station.conversation import Conversation
from pipeline.station.entries import Shown, entry, lost_entry
from pipeline.station.events import Began, Ended, Gone, Pressed
from pipeline.station.plan import Block, PlannedTrial
from pipeline.station.practice import practice_s, practise
from pipeline.station.recorder import now


class Session:
    """A participant's session from consent on: the plan minus what has ended.

    Args:
        talk: the participant before the page.
    """

    def __init__(self, talk: Conversation) -> None:
        self._talk, self._plan, self._recorder = talk, talk.plan, talk.recorder

    async def run(self) -> None:
        """Goes through all of it; returns when everything is recorded."""
        record = self._recorder
        for trial, attempt, began in record.open_attempts():
            record.line(lost_entry(self._plan, trial, attempt, datetime.fromisoformat(began)))
        if any(self._open(block) or self._asks_tlx(block) for block in self._plan.blocks):
            record.event("begin", pictures=self._plan.renderer.model_dump(mode="json"))
            await self._introduce()
            for block in self._plan.blocks:
                await self._block(block)
            record.event("end")
        self._talk.rig.show("thanks", {"code": record.code, "declined": False})

    async def _introduce(self) -> None:
        """Instructions and practice come once, the test of the gamepad whenever a station was started."""
        practised = self._recorder.has("practice")
        if not practised:
            least_s, most_s = practice_s(self._plan)
            count = sum(len(block.trials) for block in self._plan.blocks)
            about = {"frame": self._plan.params.frame, "blocks": len(self._plan.blocks), "trials": count}
            await self._talk.ask("instructions", {**about, "least_s": least_s, "most_s": most_s})
        values = await self._talk.ask("gamepad", {"dead_zone": self._plan.params.dead_zone})
        self._recorder.event("gamepad", **values.model_dump(mode="json"))
        if not practised:
            await practise(self._talk)

    def _open(self, block: Block) -> list[PlannedTrial]:
        """The block's trials that have not ended."""
        return [trial for trial in block.trials if trial.trial not in self._recorder.finished()]

    def _asks_tlx(self, block: Block) -> bool:
        """Whether NASA-TLX is still to be answered; the scripted operator has no load to tell of."""
        answered = (block.scene, block.view) in self._recorder.tlx_answered()
        return self._plan.params.tlx and self._plan.operator == "person" and not answered

    async def _block(self, block: Block) -> None:
        place = {"block": block.block, "blocks": len(self._plan.blocks)}
        trials, asks = self._open(block), self._asks_tlx(block)
        for trial in trials:
            while trial.trial not in self._recorder.finished():
                await self._trial(block, trial)
        if asks:
            values = await self._talk.ask("tlx", {"scene": block.scene, **place})
            answers = values.model_dump(mode="json")
            self._recorder.event("tlx", scene=block.scene, view=block.view, **answers)
        if (trials or asks) and block.block < len(self._plan.blocks):
            await self._talk.ask("break", place)

    async def _trial(self, block: Block, trial: PlannedTrial) -> None:
        """One attempt, from the page before it to its line on disk."""
        place = {"block": block.block, "blocks": len(self._plan.blocks)}
        number = {"trial": block.trials.index(trial) + 1, "trials": len(block.trials)}
        data = {**place, **number, **self._talk.about(block)}
        await self._talk.ask("ready", {**data, "practice": False})
        limit_s = self._plan.params.trial_limit_s
        attempt = await self._talk.begin(block, trial.start_m, trial.target_m, limit_s)
        started_at = now()
        self._talk.rig.show("trial", data)
        measured, paused = await self._measured(block, trial, attempt, started_at)
        if paused:
            self._talk.rig.rest()
            await self._talk.pause(practice=False)
        elif measured is not None:
            await self._talk.show_closing(measured)
            if self._plan.params.feedback:
                told = {"time_s": measured.time_s, "distance_m": measured.distance_m}
                await self._talk.ask("feedback", {"outcome": measured.outcome, **told})

    async def _measured(
        self, block: Block, trial: PlannedTrial, attempt: Attempt, started_at: datetime
    ) -> tuple[Measured | None, bool]:
        """Waits for the attempt's end and records it; also tells whether it was broken off."""
        number = self._recorder.next_attempt(trial.trial)
        try:
            broken_off = await self._watch(attempt, trial, number)
        finally:  # also where the station is ended meanwhile
            if attempt.measured is None:
                self._talk.rig.rest()
            if attempt.measured is not None:
                self._recorder.attempt_began(trial.trial, number)
                self._record(block, trial, number, attempt.measured, started_at)
        return attempt.measured, broken_off

    async def _watch(self, attempt: Attempt, trial: PlannedTrial, number: int) -> bool:
        """Waits for the attempt's end; True where a pause breaks it off, or because the page is gone."""
        while True:
            event = await self._talk.rig.events.get()
            if isinstance(event, Began) and event.attempt is attempt:
                self._recorder.attempt_began(trial.trial, number)
            if isinstance(event, Ended) and event.attempt is attempt:
                return False
            if isinstance(event, Gone):
                self._recorder.event("gone")
            if isinstance(event, Gone) or event == Pressed("pause"):
                return True

    def _record(
        self, block: Block, trial: PlannedTrial, number: int, measured: Measured, started_at: datetime
    ) -> None:
        rig = self._talk.rig
        shown = Shown(started_at, rig.latencies.of_attempt(), rig.sent())
        self._recorder.trial(entry(self._plan, block, trial, number, measured, shown), measured.rows)
        print(f"trial {trial.trial}, attempt {number}: {measured.outcome}{_in_words(measured)}")


def _in_words(measured: Measured) -> str:
    if measured.time_s is None or measured.distance_m is None:
        return ""
    return f", {measured.time_s:.2f} s, {100 * measured.distance_m:.2f} cm off"
