"""The scenes of a session, compiled, with a world of each."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError, unknown
from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.scene import Scene, load_scene
from pipeline.station.attempt import Attempt
from pipeline.station.params import StationParams, candidates
from pipeline.station.plan import Block
from pipeline.station.sticks import Sticks
from pipeline.station.world import World


class Stage:
    """Compiled scenes.

    Args:
        names: of the scenes.
        path: the parameter file.
    """

    def __init__(self, names: Sequence[str], path: Path = params.PARAMS_FILE) -> None:
        self.scenes: dict[str, Scene] = {name: load_scene(name, path) for name in names}
        self._worlds = {name: World(scene) for name, scene in self.scenes.items()}

    def without_gripper(self) -> list[str]:
        """The scenes whose robot has no gripper that can be closed."""
        return [name for name, world in self._worlds.items() if not world.gripper.exists]

    def digests(self) -> dict[str, str]:
        """A hash of what each scene is."""
        return {name: _digest(scene.cache_key) for name, scene in self.scenes.items()}

    def attempt(
        self, block: Block, start_m: Any, target_m: Any, given: StationParams, limit_s: float | None
    ) -> tuple[Attempt, Sticks]:
        """An attempt at its start, and how the sticks move it."""
        world = self._worlds[block.scene]
        sticks = Sticks(world.scene, block.viewpoint, given)
        world.reset(np.asarray(start_m), np.asarray(target_m))
        return Attempt(world, sticks, 1 / given.frames_per_second, limit_s), sticks


def _digest(described: object) -> str:
    return hashlib.sha256(json.dumps(described, sort_keys=True, default=str).encode()).hexdigest()


def compared_views(
    given: StationParams, chosen: Sequence[str] | None, path: Path = params.PARAMS_FILE
) -> dict[str, dict[str, Viewpoint]]:
    """The viewpoints of each task, by scene and name.

    Args:
        given: section ``station``.
        chosen: names of viewpoints to take instead of each scene's first ones.

    Raises:
        BelvedereError: a name is unknown or of another scene, or a scene is left without a view.
    """
    there = {scene: candidates(scene, path) for scene in given.tasks}
    if chosen is None:
        return {scene: dict(list(views.items())[: given.views_per_task]) for scene, views in there.items()}
    known = {name for views in there.values() for name in views}
    for name in chosen:
        if name not in known:
            raise unknown(f"viewpoint for --views, of {', '.join(given.tasks)}:", name, known)
    picked = {scene: {n: v for n, v in views.items() if n in chosen} for scene, views in there.items()}
    for scene, views in picked.items():
        if not views:
            raise BelvedereError(
                f"--views leaves scene {scene} without a view; it has {', '.join(there[scene])}."
            )
    return picked
