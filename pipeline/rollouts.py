"""Seeded random episodes of a scene: physics only, no camera; one set per repeat."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from pipeline.contract import params, seeds
from pipeline.contract.progress import Progress
from pipeline.contract.source import code_digest
from pipeline.sim.episodes import require_episodes
from pipeline.sim.exploration import roll
from pipeline.sim.params import ExplorationParams, RolloutSizes
from pipeline.sim.scene import Scene, load_scene
from pipeline.storage import zarrs
from pipeline.storage.allocation import scene_repeats
from pipeline.storage.artefacts import write_json
from pipeline.storage.repeats import REPEAT, finished, publish_store
from pipeline.storage.scratch import digest_files
from pipeline.storage.stage import entry


def main(*, scene: str, out: Path, store: Path) -> None:
    """Writes the store of episodes (layout :data:`pipeline.storage.zarrs.ROLLOUTS`), and ``out``, which says
    which episodes they are.

    Viewpoints depend on ``out`` only. It holds a hash of the repeats that every viewpoint has, so that it is
    the same however many repeats the scene has in ``store`` by now.
    """
    compiled = load_scene(scene)
    require_episodes(compiled, params.budget_section(RolloutSizes, "rollouts", scene).episodes, "rollouts")
    results = [draw_repeat(compiled, repeat) for repeat in range(scene_repeats(scene))]
    publish_store(store, results)
    first = [result / REPEAT for result in results[: params.first_repeats(scene)]]
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

    cache_key: dict[str, Any] = {"code": code_digest("rollouts"), "seed": seed, "facts": facts}
    cache_key |= {
        "scene": scene.cache_key,
        "sizes": sizes.model_dump(),
        "process": process.model_dump(),
    }
    return finished("rollouts", repeat, make, **cache_key)


if __name__ == "__main__":
    entry(main)
