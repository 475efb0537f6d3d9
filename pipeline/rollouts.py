"""Seeded random episodes of a scene: physics only, no camera; one set per repeat."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import mujoco
import numpy as np
from pydantic import Field

from pipeline.contract import params, seeds, zarrs
from pipeline.contract.allocation import scene_repeats
from pipeline.contract.artefacts import write_json
from pipeline.contract.machine import cores
from pipeline.contract.progress import Progress
from pipeline.contract.repeats import REPEAT, code_digest, finished, publish_store
from pipeline.contract.scratch import digest_files
from pipeline.contract.stage import entry
from pipeline.sim.draws import draw_episodes
from pipeline.sim.exploration import ExplorationParams, correlated_actions
from pipeline.sim.scene import Scene, load_scene
from pipeline.sim.worlds import Worlds

CODE = ("contract", "sim", "rollouts.py")
# Numbers are kept to about a millionth of a radian or metre: what processors compute differently lies far
# below, so that a newcomer's machine draws the very bytes from which the committed results come.
_GRID = 2.0**-20


class RolloutSizes(params.Section):
    """``episodes``: of each repeat."""

    episodes: Annotated[int, Field(ge=2)]


def main(*, scene: str, out: Path, store: Path) -> None:
    """Writes the store of episodes (layout :data:`pipeline.contract.zarrs.ROLLOUTS`), and ``out``, which says
    which episodes they are.

    Viewpoints depend on ``out`` only. It holds a hash of the repeats that every viewpoint has, so that it is
    the same however many repeats the scene has in ``store`` by now.
    """
    compiled = load_scene(scene)
    results = [draw_repeat(compiled, repeat) for repeat in range(scene_repeats(scene))]
    publish_store(store, results)
    first = [result / REPEAT for result in results[: params.first_repeats()]]
    write_json(out, {"scene": scene, "first_repeats": [digest_files([place]) for place in first]})


def draw_repeat(scene: Scene, repeat: int) -> Path:
    """The scratch folder of a repeat's finished episodes."""
    sizes = params.budget_section(RolloutSizes, "rollouts", scene.name)
    process, seed = params.section(ExplorationParams, "rollouts"), params.seed()
    facts = {"scene": scene.name, "mujoco": mujoco.__version__}

    def make(results: Path, running: Path) -> None:
        rng = seeds.generator(seed, repeat, seeds.Stream.ROLLOUTS)
        with Progress(scene.frames, f"rollouts {scene.name}, repeat {repeat}") as progress:
            arrays = roll(scene, sizes.episodes, process, rng, progress)
        zarrs.write(results / REPEAT, zarrs.ROLLOUTS, arrays, facts)

    decides: dict[str, Any] = {"code": code_digest(*CODE), "seed": seed, "scene": scene.params.model_dump()}
    decides |= {"sizes": sizes.model_dump(), "process": process.model_dump(), "facts": facts}
    return finished("rollouts", repeat, make, **decides)


def roll(
    scene: Scene, episodes: int, process: ExplorationParams, rng: np.random.Generator, progress: Progress
) -> dict[str, np.ndarray]:
    """One repeat's episodes: arrays of the rollouts layout."""
    drawn = draw_episodes(scene, episodes, rng)
    actions = correlated_actions((episodes, scene.frames, scene.action_size), process, rng)
    worlds = Worlds(scene, episodes, cores())
    worlds.reset(drawn)
    frames: dict[str, list[np.ndarray]] = {"qpos": [], "tip": [], "reward": []}
    for t in range(scene.frames):
        frames["qpos"].append(worlds.qpos)
        frames["tip"].append(worlds.tip)
        frames["reward"].append(worlds.step(actions[:, t]))
        progress.advance()
    stacked = {name: np.round(np.stack(values, axis=1) / _GRID) * _GRID for name, values in frames.items()}
    return {**stacked, "action": actions, "target": drawn.target_m}


if __name__ == "__main__":
    entry(main)
