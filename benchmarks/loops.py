"""What the benchmarks of the closed loop share: scenes, views, an untrained world model, controllers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch

from pipeline.contract.viewpoints import Viewpoint, viewpoint
from pipeline.control.jobs import Networks
from pipeline.control.loop import Loop, Workers
from pipeline.control.loops import Loops, closed_loops
from pipeline.control.policy import parameters
from pipeline.learning.device import set_up_torch
from pipeline.sim.scene import Scene, load_scene
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.mdnrnn import MdnRnn
from pipeline.worldmodel.vae import Vae

VIEWS = {
    "panda_1dof": (90.0, 45.0),
    "panda_2dof": (0.0, 0.0),
    "panda_2dof_obstacle": (0.0, 0.0),
    "fetch_reach": (45.0, 30.0),
}
WORLDS = 128
SIGMA = 0.1  # of the controllers' weights: they move, as in an early generation


@dataclass(frozen=True, eq=False)
class Setting:
    """A scene, a view of it, and a world model; the same numbers in every process that asks for it."""

    scene: Scene
    view: Viewpoint
    vae: Vae
    rnn: MdnRnn

    def loop(self, threads: int) -> Loop:
        """Belvedere's closed loop, on the device and in the precision that the environment chooses."""
        return Loop(Workers(self.scene, self.view, threads), Encoder(self.vae, set_up_torch()), self.rnn)

    def loops(self, threads: int) -> Loops:
        """The same as the stages have it."""
        place = set_up_torch()
        networks = Networks(Encoder(self.vae, place), self.rnn)
        return closed_loops(self.scene, self.view, [networks], place.device, threads)


def setting(name: str, frames: int | None = None) -> Setting:
    """The setting of a scene, whose episodes are cut to so many frames."""
    scene = load_scene(name)
    if frames is not None:
        scene = replace(scene, params=scene.params.model_copy(update={"frames": frames}))
    torch.manual_seed(1)
    vae = Vae().eval().requires_grad_(False)
    rnn = MdnRnn(scene.action_size, log_sigma_bound=5.0).eval().requires_grad_(False)
    return Setting(scene, viewpoint(name, *VIEWS[name]), vae, rnn)


def candidates(scene: Scene, count: int) -> np.ndarray:
    """Controllers that move: flat parameters (count, actions × 289)."""
    return SIGMA * np.random.default_rng(1).standard_normal((count, parameters(scene.action_size)))
