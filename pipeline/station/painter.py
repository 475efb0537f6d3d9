"""The thread that draws: always the newest state, never one that has been overtaken."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future

from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.scene import Scene
from pipeline.station.params import RendererName
from pipeline.station.physics import Snapshot
from pipeline.station.pictures import Choice, Renderer, choose, encoded, renderer_of

Key = tuple[str, str]  # scene and view


class Painter(threading.Thread):
    """Draws snapshots as they come, on one thread: an OpenGL context belongs to the thread that made it.

    Args:
        threads: for the ray tracer.
        painted: is given each snapshot with its encoded picture; must not wait.
    """

    def __init__(self, threads: int, painted: Callable[[Snapshot, bytes], None]) -> None:
        super().__init__(name="painter", daemon=True)
        self.failure: BaseException | None = None
        self._threads, self._painted = threads, painted
        self._wake = threading.Condition()
        self._work: list[Callable[[], None]] = []
        self._newest: Snapshot | None = None
        self._renderers: dict[Key, Renderer] = {}
        self._current: Renderer | None = None
        self._stops = False

    def choose(
        self, scene: Scene, view: Viewpoint, size: tuple[int, int], wanted: RendererName, frame_s: float
    ) -> Future[Choice]:
        """:func:`pipeline.station.pictures.choose` on this thread."""
        return self._do(lambda: choose(scene, view, size, wanted, frame_s, self._threads))

    def turn_to(self, choice: Choice, scene: Scene, name: str, view: Viewpoint) -> Future[None]:
        """From now on snapshots are of this scene, seen from the view called ``name``."""

        def turn() -> None:
            key = scene.name, name
            if key not in self._renderers:
                self._renderers[key] = renderer_of(choice, scene, view, self._threads)
            self._current = self._renderers[key]

        return self._do(turn)

    def show(self, snapshot: Snapshot) -> None:
        """A new state; one that still waits to be drawn is overtaken."""
        with self._wake:
            self._newest = snapshot
            self._wake.notify()

    def stop(self) -> None:
        """Ends the thread and frees what it drew with."""
        with self._wake:
            self._stops = True
            self._wake.notify()

    def _do(self, work: Callable[[], object]) -> Future:
        done: Future = Future()

        def run() -> None:
            try:
                done.set_result(work())
            except BaseException as error:
                done.set_exception(error)

        with self._wake:
            self._newest = None
            self._work.append(run)
            self._wake.notify()
        return done

    def run(self) -> None:
        try:
            while self._turn():
                pass
        except BaseException as error:
            self.failure = error
            raise
        finally:
            for renderer in self._renderers.values():
                renderer.close()

    def _turn(self) -> bool:
        with self._wake:
            self._wake.wait_for(lambda: bool(self._stops or self._work or self._newest))
            if self._stops:
                return False
            work, self._work = self._work, []
            snapshot = self._newest if not work else None
            self._newest = None if not work else self._newest
        for run in work:
            run()
        if snapshot is not None and self._current is not None:
            picture = self._current.draw(snapshot.qpos, snapshot.target_m)
            self._painted(snapshot, encoded(picture))
        return True
