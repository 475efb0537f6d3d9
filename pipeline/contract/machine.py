"""The machine a result is made on: cores to use, and what to say of it. No parameter."""

from __future__ import annotations

import os
import platform

from pipeline.contract.errors import BelvedereError

CORES_VARIABLE = "BELVEDERE_CORES"


def cores() -> int:
    """How many cores to use: ``$BELVEDERE_CORES``, or all that this process may run on."""
    asked = os.environ.get(CORES_VARIABLE)
    if asked is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not asked.isdigit() or int(asked) < 1:
        raise BelvedereError(f"{CORES_VARIABLE} = {asked!r} is not valid; it is a whole number from 1 up.")
    return int(asked)


def processor() -> str:
    """The processor's name, as the system gives it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    except OSError:
        names = []
    return names[0] if names else platform.processor() or platform.machine()
