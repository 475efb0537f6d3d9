"""Running a station: from the parameters to a recorded session."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.contract.errors import BelvedereError
from pipeline.station.conversation import Conversation
from pipeline.station.opengl import NoOpenGL
from pipeline.station.params import station_params
from pipeline.station.pictures import Choice
from pipeline.station.plan import Plan
from pipeline.station.planning import consent, new_plan
from pipeline.station.recorder import Recorder
from pipeline.station.rig import Rig
from pipeline.station.security import Gate
from pipeline.station.server import Server, listening_socket
from pipeline.station.session import Session
from pipeline.station.stage import Stage, compared_views
from pipeline.station.study import Study
from pipeline.station.texts import read_texts

_LINGER_S = 600.0  # the last page is shown for so long, unless it is closed


@dataclass(frozen=True)
class Asked:
    """What the command line says.

    Attributes:
        study: the folder of sessions.
        port: at which to listen.
        operator: ``person`` or ``scripted``.
        seed: of the plan; None takes that of params.yaml.
        scenes: None takes ``station.tasks``.
        views: None takes each scene's first ones.
        resume: a participant's code, or None for a new one.
    """

    study: Path
    port: int
    operator: str = "person"
    seed: int | None = None
    scenes: tuple[str, ...] | None = None
    views: Sequence[str] | None = None
    resume: str | None = None


def serve(asked: Asked) -> None:
    """Runs a station for one session.

    Raises:
        BelvedereError: something that was asked or found is not valid.
    """
    study = Study(asked.study)
    with study.alone():
        station = Station(asked, study)
        try:
            asyncio.run(station.run())
        except asyncio.CancelledError:
            raise KeyboardInterrupt from None


class Station:
    """One session's station.

    Args:
        asked: what the command line says.
        study: where it is recorded.
    """

    def __init__(self, asked: Asked, study: Study) -> None:
        self._asked, self._study = asked, study
        self._plan = study.plan(asked.resume) if asked.resume else None
        self._operator = self._plan.operator if self._plan else asked.operator
        study.require_kind(self._operator)
        self._params = self._plan.params if self._plan else station_params(tasks=asked.scenes)
        self._texts = read_texts()
        self._views = compared_views(self._params, asked.views)
        print("compiling the scenes …")
        self._stage = Stage(self._params.tasks)
        if self._plan is not None:
            self._require_same_scenes(self._plan)
        for name in self._stage.without_gripper():
            print(f"scene {name}: its robot has no gripper that an actuator closes; A only ends a trial.")

    def _require_same_scenes(self, plan: Plan) -> None:
        for name, digest in self._stage.digests().items():
            if plan.scenes.get(name) != digest:
                raise BelvedereError(
                    f"scene {name} is another one than when session {plan.participant} was planned; a "
                    "session goes on with the scenes it began with: restore params.yaml and the robot's file."
                )

    async def run(self) -> None:
        """Until the session is recorded and the page closed, or a signal comes."""
        running = asyncio.current_task()
        assert running is not None
        for name in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(name, running.cancel)
        rig = Rig(1 / self._params.frames_per_second, self._operator == "scripted")
        rig.start()
        try:
            rig.choice = await self._choose(rig)
            await self._serve(rig)
        finally:
            await asyncio.to_thread(rig.stop)

    async def _choose(self, rig: Rig) -> Choice:
        """What draws: what the plan says, or what is fast enough here."""
        if self._plan is not None:
            drawn = self._plan.renderer
            return Choice(drawn.name, drawn.size, drawn.samples, 0.0)
        scene = self._params.tasks[0]
        view = next(iter(self._views[scene].values()))
        wanted = self._params.picture, self._params.renderer, 1 / self._params.frames_per_second
        choice = await asyncio.wrap_future(rig.painter.choose(self._stage.scenes[scene], view, *wanted))
        size = " × ".join(map(str, choice.size))
        print(f"pictures: {choice.name}, {size}, {choice.milliseconds:.0f} ms each")
        return choice

    async def _serve(self, rig: Rig) -> None:
        listening = listening_socket(self._asked.port)
        gate = Gate(listening.getsockname()[1])
        server = Server(rig, gate, self._texts.page_json())
        await server.start(listening)
        print(f"open this link in a browser of this machine, once:\n\n    {gate.link}\n", flush=True)
        status = asyncio.create_task(rig.tell_status())
        course = asyncio.create_task(self._course(rig))
        try:
            await _first(course, status)
            await asyncio.wait_for(server.left.wait(), _LINGER_S)
        except TimeoutError:
            print("the last page is still open; the station ends.")
        except OSError as error:
            rig.show("error", {"reason": "storage"})
            await asyncio.sleep(1.0)
            raise BelvedereError(
                f"the session cannot be recorded in {self._study.folder} ({error.strerror}); what ended "
                "before is safe: make room or give permission, then resume."
            ) from None
        finally:
            await _ended(course, status)
            rig.rest()
            await server.stop()

    async def _course(self, rig: Rig) -> None:
        try:
            plan = self._plan or await self._new(rig)
            if plan is None:
                return
            recorder = Recorder(self._study, plan.participant.removeprefix("sub-"))
            if self._plan is None:
                recorder.begin(plan)
                if plan.consent is not None:
                    recorder.event("consent", **plan.consent.model_dump(mode="json"))
            print(f"participant {recorder.code}; if this ends early: ./run station resume {recorder.code}")
            await Session(Conversation(plan, recorder, self._stage, rig)).run()
            print(f"session of participant {recorder.code} is complete.")
        except NoOpenGL as error:
            raise BelvedereError(
                f"this session's pictures were drawn by {rig.choice and rig.choice.name}, and there is no "
                f"OpenGL here ({error}); resume it where it began."
            ) from None

    async def _new(self, rig: Rig) -> Plan | None:
        """A new participant's plan, once consent is given; None where it is not."""
        agreed = None
        if self._operator == "person":
            agreed = await consent(rig, self._texts.consent.version, self._texts.consent_sha256())
            if agreed is None:
                print("consent was declined; nothing was recorded.")
                rig.show("thanks", {"declined": True})
                return None
        assert rig.choice is not None
        asked = self._study, self._operator, self._asked.seed
        return new_plan(*asked, self._params, self._stage, self._views, rig.choice, agreed)


async def _first(course: asyncio.Task, status: asyncio.Task) -> None:
    """Waits for the course's end; raises what ended either."""
    done, _ = await asyncio.wait({course, status}, return_when=asyncio.FIRST_COMPLETED)
    for task in done:
        task.result()


async def _ended(*tasks: asyncio.Task) -> None:
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
