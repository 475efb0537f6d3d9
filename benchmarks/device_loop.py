"""The closed loop on one CUDA GPU, and one whole branch there at the paper's budget.

Where there is no CUDA device the rows say so and hold no number.
"""

from __future__ import annotations

import os
import shlex
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
import yaml

from pipeline.contract import params
from pipeline.control.device_loop import DeviceLoop
from pipeline.control.jobs import Job, Networks
from pipeline.control.policy import parameters
from pipeline.learning.device import compute
from pipeline.sim.camera import viewpoint
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.mdnrnn import MdnRnn
from pipeline.worldmodel.vae import Vae

ROOT = Path(__file__).resolve().parents[1]
VIEWS = {
    "panda_1dof": (90.0, 45.0),
    "panda_2dof": (0.0, 0.0),
    "panda_2dof_obstacle": (0.0, 0.0),
    "fetch_reach": (45.0, 30.0),
}
CANDIDATES, EPISODES, ROUNDS = 64, 64, 3  # 4,096 worlds
SIGMA = 0.1  # of the controllers' weights: they move, as in an early generation
# Madrona-MJX's published PandaPickCube, simulation and pictures without any network, on an RTX 4090
PEER, GOAL = 36_900.0, 100_000.0
BRANCH = ("frames", "vae", "latents", "mdnrnn", "controller", "evaluation")  # the stages of one viewpoint
BUDGET, BRANCH_SCENE, GOAL_MIN = "paper", "panda_2dof", 5.0


def measure() -> list[dict[str, Any]]:
    """A row for each scene's loop, and one for a branch."""
    there = compute().device.type == "cuda"
    loops = [loop_row(name, frames_per_s(name) if there else None) for name in VIEWS]
    return [*loops, branch_row(branch_min(BUDGET, BRANCH_SCENE) if there else None)]


def loop_row(scene: str, ours: float | None) -> dict[str, Any]:
    """The row of frames a second, or of none."""
    ratio = None if ours is None else ours / PEER
    return {
        "work": "closed loop on one CUDA GPU",
        "scene": scene,
        "ours": ours,
        "peer": PEER,
        "unit": "frames/s",
        "ratio": ratio,
        "goal": GOAL / PEER,
        "holds": None if ratio is None else ratio >= GOAL / PEER,
        "goal_is": "at least",
        "note": _note(ours),
    }


def branch_row(ours: float | None) -> dict[str, Any]:
    """The row of a branch's minutes, or of none."""
    return {
        "work": f"one branch, budget {BUDGET}, one GPU",
        "scene": BRANCH_SCENE,
        "ours": ours,
        "peer": None,
        "unit": "minutes",
        "ratio": None,
        "goal": GOAL_MIN,
        "holds": None if ours is None else ours <= GOAL_MIN,
        "goal_is": "at most",
        "note": _note(ours),
    }


def _note(ours: float | None) -> str:
    return "not measured: no CUDA device" if ours is None else torch.cuda.get_device_name()


def frames_per_s(name: str, candidates: int = CANDIDATES, episodes: int = EPISODES) -> float:
    """Of whole calls, from drawn episodes to traces on the host; the median of a few rounds."""
    scene, view, place = load_scene(name), viewpoint(name, *VIEWS[name]), compute()
    torch.manual_seed(1)
    networks = Networks(Encoder(Vae(), place), MdnRnn(scene.action_size, log_sigma_bound=5.0).eval())
    loop, rng = DeviceLoop(scene, view, [networks], place.device), np.random.default_rng(1)
    flat = SIGMA * rng.standard_normal((candidates, parameters(scene.action_size)))
    job = Job.of(0, flat, draw_episodes(scene, episodes, rng))
    loop.run([job])  # compiles the kernels and captures the graph
    seconds = []
    for _ in range(ROUNDS):
        begin_s = time.perf_counter()
        loop.run([job])
        seconds.append(time.perf_counter() - begin_s)
    return candidates * episodes * scene.frames / statistics.median(seconds)


def branch_min(budget: str, scene: str) -> float:
    """Minutes that the stages of one viewpoint take, as dvc.yaml runs them, from the scene's rollouts on."""
    tree = yaml.safe_load((ROOT / params.PARAMS_FILE).read_text(encoding="utf-8"))
    theta, phi = VIEWS[scene]
    tree |= {"budget": budget, "viewpoint": {"scene": scene, "theta": theta, "phi": phi}}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / params.PARAMS_FILE).write_text(yaml.safe_dump(tree), encoding="utf-8")
        _run_stages(["rollouts"], {"${item}": scene}, folder)
        names = {"${key}": "study", "${item.scene}": scene, "${item.theta}": theta, "${item.phi}": phi}
        begin_s = time.perf_counter()
        _run_stages(BRANCH, names, folder)
        return (time.perf_counter() - begin_s) / 60


def _run_stages(stages: Sequence[str], names: dict[str, Any], folder: str) -> None:
    declared = yaml.safe_load((ROOT / "dvc.yaml").read_text(encoding="utf-8"))["stages"]
    for stage in stages:
        command = declared[stage]["do"]["cmd"]
        for name, value in names.items():
            command = command.replace(name, str(value))
        program, *flags = shlex.split(command)
        if program != "python":
            raise ValueError(f"stage {stage} is run by {program}, not by python")
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "BELVEDERE_SCRATCH": f"{folder}/scratch"}
        subprocess.run([sys.executable, *flags], cwd=folder, env=environment, check=True)


if __name__ == "__main__":
    print(*measure(), sep="\n")
