"""A new participant: consent, a code, and the plan of the session."""

from __future__ import annotations

import platform
import subprocess
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pipeline.contract import params
from pipeline.contract.machine import cores, processor
from pipeline.contract.viewpoints import Viewpoint
from pipeline.station import plan as plans
from pipeline.station.events import Answered
from pipeline.station.params import StationParams
from pipeline.station.pictures import Choice
from pipeline.station.plan import Consent, DrawnBy, Plan
from pipeline.station.recorder import now
from pipeline.station.rig import Rig
from pipeline.station.stage import Stage
from pipeline.station.study import SESSION, Study


async def consent(rig: Rig, text_version: str, text_sha256: str) -> Consent | None:
    """Asks for consent to a text; None where it is declined, or another text was shown."""
    rig.show("consent", {})
    while True:
        event = await rig.events.get()
        if isinstance(event, Answered) and event.page == "consent":
            break
    if not event.values.accepted or event.values.version != text_version:
        return None
    return Consent(version=text_version, sha256=text_sha256, accepted_at=now())


def new_plan(
    study: Study,
    operator: str,
    seed: int | None,
    given: StationParams,
    stage: Stage,
    views: dict[str, dict[str, Viewpoint]],
    choice: Choice,
    agreed: Consent | None,
) -> Plan:
    """The plan of the study's next participant, who gets a code.

    Args:
        study: whose earlier plans are balanced.
        operator: ``person`` or ``scripted``.
        seed: None takes that of params.yaml.
        given: section ``station``.
        stage: the scenes.
        views: the compared viewpoints by scene and name.
        choice: what draws.
        agreed: the consent, of a person.
    """
    earlier = study.plans()
    root = params.seed() if seed is None else seed
    rng = plans.generator(root, len(earlier))
    had = [plan.blocks for plan in earlier]
    return Plan.model_validate(
        {
            "participant": f"sub-{study.new_code()}",
            "session": SESSION,
            "operator": operator,
            "seed": root,
            "number": len(earlier),
            "created": now(),
            "provenance": provenance(),
            "params": given,
            "scenes": stage.digests(),
            "renderer": DrawnBy(name=choice.name, size=choice.size, samples=choice.samples),
            "consent": agreed,
            "blocks": plans.planned_blocks(stage.scenes, views, had, given.trials, rng),
        }
    )


def provenance() -> dict[str, Any]:
    """Code, versions and machine."""
    packages = {name: version(name) for name in ("mujoco", "mujoco-warp", "numpy", "aiohttp")}
    machine = f"{platform.machine()} {processor()}, {cores()} cores"
    return {"revision": _revision(), "python": platform.python_version(), **packages, "machine": machine}


def _revision() -> str:
    root = Path(__file__).resolve().parents[2]
    command = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return "not under git"
    return done.stdout.strip() if done.returncode == 0 else "not under git"
