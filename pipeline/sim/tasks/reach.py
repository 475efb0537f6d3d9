"""Reach: the tip is to come to a sphere that rests, paper section II-A."""

from __future__ import annotations

from typing import ClassVar, Literal

from pipeline.sim.tasks.base import Task


class Reach(Task):
    """All as :class:`Task` has it."""

    own_arrays: ClassVar[bool] = False

    kind: Literal["reach"]
