"""Practice: grasps that count for nothing, in every scene and view of the plan alike (paper section IV-C)."""

from __future__ import annotations

import asyncio
import itertools
import time

from pipeline.sim.draws import draw_episodes
from pipeline.station import plan as plans
from pipeline.station.attempt import Attempt
from pipeline.station.conversation import Conversation
from pipeline.station.events import Answered, Ended, Gone, Pressed
from pipeline.station.plan import Block, Plan
from pipeline.station.recorder import PracticeLine, now


def practice_s(plan: Plan) -> tuple[float, float]:
    """Shortest and longest practice; the scripted operator needs none."""
    least_s, most_s = plan.params.practice_s
    return (0.0 if plan.operator == "scripted" else least_s), most_s


async def practise(talk: Conversation) -> None:
    """Goes on until the participant has had enough, within the times of the plan; pauses do not count."""
    plan = talk.plan
    least_s, most_s = practice_s(plan)
    rng = plans.generator(plan.seed, plan.number, practice=True)
    spent_s, enough = 0.0, False
    for block in itertools.cycle(plan.blocks):
        if enough or spent_s >= most_s:
            break
        drawn = draw_episodes(talk.stage.scenes[block.scene], 1, rng)
        attempt = await talk.begin(block, drawn.start_m[0], drawn.target_m[0], None)
        times = {"elapsed_s": spent_s, "least_s": least_s, "most_s": most_s}
        talk.rig.show("practice", {**talk.about(block), **times})
        begin_s = time.monotonic()
        enough, paused = await _watch(talk, attempt, least_s - spent_s, most_s - spent_s)
        spent_s += time.monotonic() - begin_s
        await _end(talk, block, attempt, paused)
    talk.recorder.event("practice", seconds=round(spent_s, 1))


async def _watch(talk: Conversation, attempt: Attempt, least_s: float, most_s: float) -> tuple[bool, bool]:
    """Whether the participant has had enough, and whether there was a pause."""
    begin_s = time.monotonic()
    while (left_s := begin_s + most_s - time.monotonic()) > 0:
        try:
            event = await asyncio.wait_for(talk.rig.events.get(), left_s)
        except TimeoutError:
            break
        if isinstance(event, Ended) and event.attempt is attempt:
            return False, False
        if isinstance(event, Gone):
            talk.recorder.event("gone")
        if isinstance(event, Gone) or event == Pressed("pause"):
            return False, True
        early = time.monotonic() - begin_s < least_s
        if isinstance(event, Answered) and event.page == "practice" and not early:
            return True, False
    return True, False


async def _end(talk: Conversation, block: Block, attempt: Attempt, paused: bool) -> None:
    measured = attempt.measured
    if measured is None:
        talk.rig.rest()
    else:
        line = PracticeLine(
            practice=True,
            at=now(),
            scene=block.scene,
            view=block.view,
            time_s=measured.time_s,
            distance_m=measured.distance_m,
            path_m=measured.path_m,
        )
        talk.recorder.practice(line)
        await talk.show_closing(measured)
    if paused:
        await talk.pause(practice=True)
