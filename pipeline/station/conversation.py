"""What the parts of a session's course have in common: pages that are answered, pauses, attempts."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

from pipeline.station.attempt import GRASPED, Attempt, Measured
from pipeline.station.events import Answered, Gone, Pressed
from pipeline.station.plan import Block, Plan
from pipeline.station.recorder import Recorder
from pipeline.station.rig import Rig
from pipeline.station.stage import Stage

CLOSING_S = 0.6  # the closing gripper is shown for so long


class Conversation:
    """A participant before the page.

    Args:
        plan: of the session.
        recorder: of its files.
        stage: scenes and worlds.
        rig: physics, pictures, page.
    """

    def __init__(self, plan: Plan, recorder: Recorder, stage: Stage, rig: Rig) -> None:
        self.plan, self.recorder, self.stage, self.rig = plan, recorder, stage, rig

    async def ask(self, page: str, data: Mapping[str, Any]) -> Any:
        """Shows a page until it is answered; returns the answer's values."""
        self.rig.show(page, data)
        while True:
            event = await self.rig.events.get()
            if isinstance(event, Answered) and event.page == page:
                return event.values
            if isinstance(event, Gone):
                self.recorder.event("gone")

    async def pause(self, practice: bool) -> None:
        """Waits, the picture hidden, until somebody goes on."""
        self.recorder.event("pause")
        self.rig.show("paused", {"practice": practice})
        while (event := await self.rig.events.get()) != Pressed("resume"):
            if isinstance(event, Gone):
                self.recorder.event("gone")
        self.recorder.event("resume")

    async def begin(self, block: Block, start_m: Any, target_m: Any, limit_s: float | None) -> Attempt:
        """Shows the block's scene from its view, the tip at a start (3,) before a target (3,), m."""
        given, scene = self.plan.params, self.stage.scenes[block.scene]
        attempt, sticks = await asyncio.to_thread(
            self.stage.attempt, block, start_m, target_m, given, limit_s
        )
        await self.rig.begin(attempt, sticks, scene, block.view, block.viewpoint)
        return attempt

    async def show_closing(self, measured: Measured) -> None:
        """Shows the gripper close after a grasp; then nothing moves."""
        if measured.outcome == GRASPED:
            await asyncio.sleep(CLOSING_S)
        self.rig.rest()

    def about(self, block: Block) -> dict[str, Any]:
        """What a page is told of a block's scene: nothing of any view."""
        axes = list(self.stage.scenes[block.scene].params.axes)
        return {"scene": block.scene, "axes": axes, "frame": self.plan.params.frame}
