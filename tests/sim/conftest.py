"""Scenes and views as params.yaml declares them."""

from __future__ import annotations

from functools import cache

import pytest

from pipeline.contract import params
from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.params import SceneParams
from pipeline.sim.robot_params import robot_params
from pipeline.sim.scene import Scene, compile_scene, load_scene
from tests.support import ROOT

SCENES = tuple(params.value("scenes"))
VIEWS = tuple(Viewpoint(**view) for view in params.value("viewpoints").values())


@cache
def compiled(name: str) -> Scene:
    return load_scene(name)


def compile_changed(name: str, scene: SceneParams) -> Scene:
    """A described scene with a robot of params.yaml."""
    return compile_scene(name, scene, robot_params(scene.robot), ROOT)


@pytest.fixture(params=SCENES)
def scene(request: pytest.FixtureRequest) -> Scene:
    return compiled(request.param)


@pytest.fixture(params=VIEWS, ids=lambda view: f"{view.scene}({view.theta:g},{view.phi:g})")
def view(request: pytest.FixtureRequest) -> Viewpoint:
    return request.param
