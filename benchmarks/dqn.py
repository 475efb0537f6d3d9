"""DQN training: frames a second against acting alone, gradient steps a second against the bare network."""

from __future__ import annotations

import statistics

import numpy as np
import torch
from stable_baselines3 import DQN

from benchmarks import timing
from benchmarks.rows import Row, goal_row
from pipeline.contract import params
from pipeline.contract.machine import cores
from pipeline.contract.viewpoints import viewpoint
from pipeline.learning.device import set_up_torch
from pipeline.qlearning.params import DqnParams, DqnSizes
from pipeline.qlearning.task_env import TaskEnv
from pipeline.qlearning.training import network
from pipeline.sim.scene import load_scene

SCENE, THETA_DEG, PHI_DEG = "fetch_reach", 45.0, 30.0
ROUNDS, EPISODES, STEPS = 3, 2, 100


def measure() -> list[Row]:
    """Two rows: medians over rounds in which ours and the peer are measured in turn. No goal is set."""
    method = params.section(DqnParams, "dqn")
    sizes = params.section(DqnSizes, "budgets", "quick", "dqn")
    scene, place = load_scene(SCENE), set_up_torch()
    env = TaskEnv(
        scene, viewpoint(SCENE, THETA_DEG, PHI_DEG), method.worlds, np.random.default_rng(1), cores()
    )
    frames = EPISODES * scene.frames * method.worlds
    sizes = sizes.model_copy(update={"frames": frames, "memory": frames})
    model = network(env, method, sizes, place, 1)
    model.learning_starts = 0  # each call begins to count again, and is to learn from its first frame
    model.learn(frames // EPISODES)  # also the first call, which compiles
    pictures = torch.randint(256, (method.batch, 3, 64, 64), device=place.device) / 255.0
    seconds: dict[str, list[float]] = {"learn": [], "act": [], "train": [], "network": []}
    for _ in range(ROUNDS):
        seconds["learn"].append(timing.seconds(lambda: model.learn(frames)))
        seconds["act"].append(timing.seconds(lambda: _act(model, env)))
        seconds["train"].append(timing.seconds(lambda: model.train(STEPS, method.batch)))
        seconds["network"].append(timing.seconds(lambda: _network_alone(model, pictures)))
    return [
        _row("DQN training, against acting alone", "frames/s", frames, seconds["learn"], seconds["act"]),
        _row("DQN steps, against the bare network", "steps/s", STEPS, seconds["train"], seconds["network"]),
    ]


def _act(model: DQN, env: TaskEnv) -> None:
    """The same episodes, acted in and not learned from."""
    pictures = np.asarray(env.reset())
    for _ in range(EPISODES * env.frames):
        chosen, _ = model.predict(pictures, deterministic=True)
        pictures = np.asarray(env.step(chosen)[0])


def _network_alone(model: DQN, pictures: torch.Tensor) -> None:
    """As many gradient steps of the network on one batch, and once more forward for the target network."""
    for _ in range(STEPS):
        values = model.q_net.q_net(model.q_net.features_extractor(pictures))
        with torch.no_grad():
            target = model.q_net_target.q_net(model.q_net_target.features_extractor(pictures))
        model.policy.optimizer.zero_grad()
        (values - target).square().mean().backward()
        model.policy.optimizer.step()


def _row(work: str, unit: str, amount: int, ours: list[float], peer: list[float]) -> Row:
    ratio = statistics.median(other / mine for mine, other in zip(ours, peer, strict=True))
    rates = amount / statistics.median(ours), amount / statistics.median(peer)
    return goal_row(work, SCENE, *rates, unit, ratio, None)
