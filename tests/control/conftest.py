"""Short episodes of a real scene, and a world model that has learned nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from pipeline.control.loop import Loop
from pipeline.learning.device import Compute
from pipeline.sim.camera import viewpoint
from pipeline.sim.scene import Scene, load_scene
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.mdnrnn import MdnRnn
from pipeline.worldmodel.vae import Vae

FRAMES = 4


@pytest.fixture(scope="session")
def scene() -> Scene:
    """Scene panda_2dof, cut to a few frames."""
    loaded = load_scene("panda_2dof")
    return replace(loaded, params=loaded.params.model_copy(update={"frames": FRAMES}))


@pytest.fixture(scope="session")
def world_model(scene: Scene) -> tuple[Vae, MdnRnn]:
    torch.manual_seed(1)
    return Vae().eval().requires_grad_(False), MdnRnn(scene.action_size, log_sigma_bound=5.0).eval()


@pytest.fixture(scope="session")
def loops(scene: Scene, world_model: tuple[Vae, MdnRnn]) -> dict[int, Loop]:
    """Loops over the same scene and world model, by their number of threads."""
    vae, rnn = world_model
    encoder = Encoder(vae, Compute(torch.device("cpu"), torch.float32))
    return {threads: Loop(scene, viewpoint("panda_2dof", 0, 0), encoder, rnn, threads) for threads in (1, 2)}
