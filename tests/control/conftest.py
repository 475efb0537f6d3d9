"""Short episodes of a real scene, and a world model that has learned nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from pipeline.contract.viewpoints import viewpoint
from pipeline.control.jobs import Networks
from pipeline.control.loop import Loop, Workers
from pipeline.learning.device import Compute
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
    view = viewpoint("panda_2dof", 0, 0)
    return {threads: Loop(Workers(scene, view, threads), encoder, rnn) for threads in (1, 2)}


@pytest.fixture(scope="session")
def networks(scene: Scene) -> list[Networks]:
    """The networks of two repeats, on the CPU; they have learned nothing."""
    return untrained(scene.action_size, torch.device("cpu"))


def untrained(actions: int, device: torch.device) -> list[Networks]:
    """Two different world models whose encoders compute on ``device``, in float32."""
    made = []
    for seed in (1, 2):
        torch.manual_seed(seed)
        encoder = Encoder(Vae().eval().requires_grad_(False), Compute(device, torch.float32))
        made.append(Networks(encoder, MdnRnn(actions, log_sigma_bound=5.0).eval().requires_grad_(False)))
    return made
