"""The tasks that a scene can declare, one file each; see :class:`pipeline.sim.tasks.base.Task`."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pipeline.sim.tasks.align import Align
from pipeline.sim.tasks.follow import Follow
from pipeline.sim.tasks.push import Push
from pipeline.sim.tasks.reach import Reach

# To add a task: a file with its class, and the class here.
AnyTask = Annotated[Reach | Align | Follow | Push, Field(discriminator="kind")]
REACH = Reach(kind="reach")
