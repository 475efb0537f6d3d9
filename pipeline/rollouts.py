"""Seeded random episodes of a scene: physics only, no camera; one set per repeat."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import mujoco
import numpy as np
from pydantic import Field

from pipeline.contract import params, seeds, zarrs
from pipeline.contract.machine import cores
from pipeline.contract.progress import Progress
from pipeline.contract.stage import entry
from pipeline.sim.draws import draw_episodes
from pipeline.sim.exploration import ExplorationParams, correlated_actions
from pipeline.sim.scene import Scene, load_scene
from pipeline.sim.worlds import Worlds

# Numbers are kept to about a millionth of a radian or metre: what processors compute differently lies far
# below, so that a newcomer's machine draws the very bytes from which the committed results come.
_GRID = 2.0**-20


class RolloutSizes(params.Section):
    """``episodes``: of each repeat."""

    episodes: Annotated[int, Field(ge=2)]


def main(*, scene: str, out: Path) -> None:
    """Writes ``data/rollouts/SCENE.zarr`` (layout :data:`pipeline.contract.zarrs.ROLLOUTS`)."""
    compiled = load_scene(scene)
    sizes = params.budget_section(RolloutSizes, "rollouts")
    process = params.section(ExplorationParams, "rollouts")
    repeats = params.repeats()
    with Progress(repeats * compiled.frames, f"rollouts {scene}") as progress:
        blocks = [
            roll(
                compiled,
                sizes.episodes,
                process,
                seeds.generator(params.seed(), r, seeds.Stream.ROLLOUTS),
                progress,
            )
            for r in range(repeats)
        ]
    arrays = {name: np.stack([block[name] for block in blocks]) for name in zarrs.ROLLOUTS}
    zarrs.write(out, zarrs.ROLLOUTS, arrays, {"scene": scene, "mujoco": mujoco.__version__})


def roll(
    scene: Scene, episodes: int, process: ExplorationParams, rng: np.random.Generator, progress: Progress
) -> dict[str, np.ndarray]:
    """One repeat's episodes: arrays of the rollouts layout without their leading axis."""
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
