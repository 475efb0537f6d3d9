"""The scenes that examples/tasks declares."""

from __future__ import annotations

from functools import cache

from pipeline.contract import params
from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.params import SceneParams
from pipeline.sim.scene import Scene
from tests.sim.conftest import compile_changed
from tests.support import ROOT

KINDS = ("align", "follow", "push")


@cache
def example(kind: str) -> Scene:
    """The example scene of a task."""
    name, file = f"panda_{kind}", ROOT / f"examples/tasks/{kind}.yaml"
    return compile_changed(name, params.section(SceneParams, "scenes", name, path=file))


def example_views(kind: str) -> dict[str, Viewpoint]:
    """Its viewpoints, by name."""
    views = params.value("viewpoints", path=ROOT / f"examples/tasks/{kind}.yaml")
    return {name: Viewpoint(**view) for name, view in views.items()}
