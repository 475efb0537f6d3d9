"""Somebody who goes through a person's session in the browser, and what that somebody sees on the way."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from axe_playwright_python.sync_playwright import Axe

from tests.station.browser import Watched
from tests.station.sessions import file_of

A, BACK, START = 0, 8, 9
ZONE, SPEED_M_S = 0.12, 0.25  # params.yaml, section station

# On a busy machine the page's own clock is no help: a push lasts so long by that of the pictures' headers.
SIMULATED_CLOCK = """
window.simulated_ms = 0;
const Real = WebSocket;
window.WebSocket = class extends Real {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({data}) => {
      if (data instanceof ArrayBuffer) window.simulated_ms = new DataView(data).getUint32(8, true);
    });
  }
};
window.simulated = async (seconds) => {
  const begin = window.simulated_ms;
  while (window.simulated_ms < begin + 1000 * seconds) await new Promise((done) => setTimeout(done, 5));
};
"""


@dataclass
class Walk:
    """What a walk through a session saw."""

    folder: Path
    pages: list[str] = field(default_factory=list)
    barriers: dict[str, str] = field(default_factory=dict)
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)
    exit_status: int | None = None
    origin: str = ""


def stick(share: float) -> float:
    """A stick's travel for a share of full speed."""
    return math.copysign(ZONE + abs(share) * (1 - ZONE), share) if share else 0.0


class Participant:
    """Somebody who knows from the plan where the target is, and steers there without looking."""

    def __init__(self, watched: Watched, walk: Walk) -> None:
        self.watched, self.walk = watched, walk
        self.done = 0
        self.broken_off: set[str] = set()

    def page(self, previous: str) -> str:
        """Waits for a page other than the one before, and looks whether everybody can read it."""
        self.watched.page.wait_for_function(
            "previous => document.body.dataset.page && document.body.dataset.page !== previous", arg=previous
        )
        name = self.watched.page.evaluate("document.body.dataset.page")
        self.walk.pages.append(name)
        if name not in self.walk.barriers:
            found = Axe().run(self.watched.page)
            self.walk.barriers[name] = found.generate_report() if found.violations_count else ""
        return name

    def trials(self) -> list[dict[str, Any]]:
        plan = json.loads(file_of(self.walk.folder, "plan.json").read_text(encoding="utf-8"))
        return [{**trial, "scene": block["scene"]} for block in plan["blocks"] for trial in block["trials"]]

    def steer(self, way_m: np.ndarray, keyboard: bool) -> None:
        """Pushes sticks, or holds keys, for as long as it takes at the speed of the station's parameters."""
        page = self.watched.page
        page.wait_for_selector("canvas:not(.empty)")
        page.evaluate("simulated(0.2)")
        if keyboard:
            key = "ArrowUp" if way_m[2] > 0 else "ArrowDown"
            page.keyboard.down(key)
            page.evaluate("simulated", abs(way_m[2]) / SPEED_M_S)
            page.keyboard.up(key)
        else:
            seconds = max(float(np.abs(way_m).max()) / SPEED_M_S, 0.2)
            y, z = (float(way) / (SPEED_M_S * seconds) for way in way_m[1:])
            axes = [stick(-y), 0, 0, stick(-z)]  # robot frame: right leads to -y, and down to -z
            page.evaluate(
                "async ([axes, s]) => { pad.axes = axes; await simulated(s); pad.axes = [0, 0, 0, 0]; }",
                [axes, seconds],
            )
        page.evaluate("simulated(0.3)")

    def trial(self) -> None:
        trial = self.trials()[self.done]
        way_m = np.subtract(trial["target_m"], trial["start_m"])
        scene, page = trial["scene"], self.watched.page
        self.steer(way_m, keyboard=scene == "panda_1dof")
        if scene == "panda_2dof" and scene not in self.broken_off:
            self.broken_off.add(scene)
            self.watched.press(BACK)
        elif scene == "panda_2dof_obstacle" and scene not in self.broken_off:
            self.broken_off.add(scene)
            page.reload()
            self.watched.connect_pad()
        elif scene == "panda_1dof":
            page.keyboard.press("Enter")
            self.done += 1
        else:
            self.watched.press(A)
            self.done += 1

    def gamepad(self) -> None:
        self.watched.page.wait_for_selector(".steps li:nth-child(1).done")
        for axes in ([0, -1, 0, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 0, -1], [0, 0, 0, 1]):
            self.watched.sticks((axes[0], axes[1]), (axes[2], axes[3]))
            self.watched.wait(0.15)
        self.watched.sticks()
        self.watched.press(A)
        self.watched.press(START)
        self.watched.page.get_by_role("button", name="Go on with the gamepad").click()

    def tlx(self) -> None:
        for _ in range(6):
            self.watched.page.keyboard.press("Tab")
            self.watched.page.keyboard.press("ArrowRight")
        self.watched.page.get_by_role("button").click()

    def go_on(self, name: str) -> None:
        """Leaves a page as a person would."""
        if name == "consent":
            self.watched.page.get_by_role("checkbox").check()
            self.watched.page.get_by_role("button", name="Agree").click()
        elif name == "gamepad":
            self.gamepad()
        elif name == "practice":
            self.watched.page.wait_for_selector("canvas:not(.empty)")
            self.watched.page.get_by_role("button", name="Begin the trials").click(timeout=60_000)
        elif name == "trial":
            self.trial()
        elif name == "tlx":
            self.tlx()
        else:
            self.watched.press(A)
