"""Scenes and views as params.yaml declares them."""

from __future__ import annotations

from functools import cache

import pytest

from pipeline.contract import params
from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.scene import Scene, load_scene

SCENES = tuple(params.value("scenes"))
VIEWS = tuple(Viewpoint(**view) for view in params.value("viewpoints").values())


@cache
def compiled(name: str) -> Scene:
    return load_scene(name)


@pytest.fixture(params=SCENES)
def scene(request: pytest.FixtureRequest) -> Scene:
    return compiled(request.param)


@pytest.fixture(params=VIEWS, ids=lambda view: f"{view.scene}({view.theta:g},{view.phi:g})")
def view(request: pytest.FixtureRequest) -> Viewpoint:
    return request.param
