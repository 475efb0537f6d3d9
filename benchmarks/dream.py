"""A generation of a search in the MDN-RNN's dream against one in the closed loop: the same controllers."""

from __future__ import annotations

import statistics
import time

import numpy as np
import torch

from benchmarks.loops import candidates, setting
from benchmarks.rows import Row, goal_row
from pipeline.ablations.dream import Dream, DreamLoops, learn_reward
from pipeline.ablations.params import AblationParams
from pipeline.contract import params
from pipeline.contract.machine import cores
from pipeline.control.jobs import Job
from pipeline.control.loops import Loops
from pipeline.sim.draws import draw_episodes
from pipeline.worldmodel.vae import LATENTS

SCENE, CANDIDATES, EPISODES, ROUNDS = "panda_2dof", 16, 4, 5


def measure() -> Row:
    """Frames a second of both, as the ratio of medians."""
    chosen = setting(SCENE)
    scene, declared = chosen.scene, params.section(AblationParams, "ablation").dream
    latents = torch.randn(64, 8, LATENTS, generator=torch.Generator().manual_seed(1))
    reward = learn_reward(
        latents, torch.zeros_like(latents), latents[..., 0].double(), declared.reward, seed=1
    )
    dream = DreamLoops(scene, [Dream(chosen.rnn, reward, latents[:, 0], declared.temperature)])
    real = chosen.loops(threads=cores())
    job = Job.of(0, candidates(scene, CANDIDATES), draw_episodes(scene, EPISODES, np.random.default_rng(1)))
    frames = CANDIDATES * EPISODES * scene.frames
    ours, theirs = (frames / _seconds(loops, job) for loops in (dream, real))
    work = "generation dreamt, against the closed loop"
    return goal_row(work, SCENE, ours, theirs, "frames/s", ours / theirs, None)


def _seconds(loops: Loops, job: Job) -> float:
    list(loops.run([job]))
    taken = []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        list(loops.run([job]))
        taken.append(time.perf_counter() - begin)
    return statistics.median(taken)
