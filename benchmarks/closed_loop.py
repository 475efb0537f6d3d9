"""The closed loop at 128 worlds, in frames a second, against rendering the same worlds and nothing else."""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np
import torch

from pipeline.contract.machine import cores
from pipeline.control.loop import Loop
from pipeline.control.policy import Controllers, parameters
from pipeline.learning.device import compute
from pipeline.sim.camera import viewpoint
from pipeline.sim.draws import draw_episodes
from pipeline.sim.images import Gallery
from pipeline.sim.scene import load_scene
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.mdnrnn import MdnRnn
from pipeline.worldmodel.vae import Vae

VIEWS = {
    "panda_1dof": (90.0, 45.0),
    "panda_2dof": (0.0, 0.0),
    "panda_2dof_obstacle": (0.0, 0.0),
    "fetch_reach": (45.0, 30.0),
}
WORLDS, ROUNDS = 128, 5
GOAL = 0.6
SIGMA = 0.1  # of the controllers' weights: they move, as in an early generation


def measure() -> list[dict[str, Any]]:
    """One row per scene: medians over rounds in which both are measured in turn, on all cores."""
    return [measure_scene(name, *angles) for name, angles in VIEWS.items()]


def measure_scene(name: str, theta_deg: float, phi_deg: float) -> dict[str, Any]:
    """The row of one scene."""
    scene, view = load_scene(name), viewpoint(name, theta_deg, phi_deg)
    torch.manual_seed(1)
    encoder, rnn = Encoder(Vae(), compute()), MdnRnn(scene.action_size, log_sigma_bound=5.0).eval()
    loop, gallery = Loop(scene, view, encoder, rnn, cores()), Gallery(scene, view, cores())
    rng = np.random.default_rng(1)
    episodes = draw_episodes(scene, WORLDS, rng)
    candidates = SIGMA * rng.standard_normal((WORLDS, parameters(scene.action_size)))
    controllers = Controllers.of(candidates, scene.action_size)
    trace = loop.run(controllers, episodes)  # also the first call, which compiles
    seen = trace.qpos[:, :-1].reshape(-1, trace.qpos.shape[2])  # the states that the closed loop rendered
    targets = np.repeat(episodes.target_m, scene.frames, axis=0)
    gallery.render(seen[:WORLDS], targets[:WORLDS], drawn=lambda count: None)
    ours, peer = [], []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        loop.run(controllers, episodes)
        middle = time.perf_counter()
        gallery.render(seen, targets, drawn=lambda count: None)
        end = time.perf_counter()
        ours.append(WORLDS * scene.frames / (middle - begin))
        peer.append(WORLDS * scene.frames / (end - middle))
    ratio = statistics.median(mine / other for mine, other in zip(ours, peer, strict=True))
    return {
        "work": "closed loop, 128 worlds",
        "scene": name,
        "ours": statistics.median(ours),
        "peer": statistics.median(peer),
        "unit": "frames/s",
        "ratio": ratio,
        "goal": GOAL,
        "holds": ratio >= GOAL,
    }
