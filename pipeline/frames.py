"""Replays a scene's episodes and renders them from one viewpoint."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import mujoco

from pipeline.contract import params
from pipeline.contract.machine import cores
from pipeline.contract.progress import Progress
from pipeline.contract.source import code_digest
from pipeline.contract.viewpoints import Viewpoint, viewpoint
from pipeline.rendering.renderer import ParallelRenderer
from pipeline.rendering.replay import render, write_pictures
from pipeline.rendering.visibility import refuse_hidden_targets
from pipeline.sim.scene import Scene, load_scene, with_camera
from pipeline.storage import zarrs
from pipeline.storage.allocation import branch_repeats
from pipeline.storage.artefacts import writing
from pipeline.storage.repeats import REPEAT, finished, publish_store
from pipeline.storage.scratch import digest_files
from pipeline.storage.stage import entry


def main(
    *,
    branch: str,
    scene: str,
    theta: float,
    phi: float,
    rollouts: Path,
    out: Path,
    picture: Path,
    distance: float = 0,
    fov: float = 0,
    first: int = 0,
) -> None:
    """Writes the frames' store (layout :data:`pipeline.storage.zarrs.FRAMES`) and two pictures of the view.

    ``rollouts`` is what stage rollouts says of the episodes; their store is the folder of the same name
    beside it. ``picture`` becomes a folder with ``view.png`` (for people) and ``view_64.png`` (64 × 64, as
    the world model sees it). ``distance``, m, and ``fov``, degrees, are the camera's; 0: the scene's.
    ``first``: repeats that the branch has at least; without it the budget's.
    """
    compiled, view = with_camera(load_scene(scene), distance, fov), viewpoint(scene, theta, phi)
    refuse_hidden_targets(compiled, view)
    store = zarrs.Store(rollouts.with_suffix(""), zarrs.ROLLOUTS, f"rollouts@{scene}")
    studio = Studio(compiled, view)
    count = branch_repeats(branch, view, first or params.first_repeats(scene))
    results = [studio.repeat(store, r) for r in range(count)]
    publish_store(out, results)
    with writing(picture) as folder:
        folder.mkdir()
        write_pictures(folder, compiled, view, store)


class Studio:
    """Renders repeats of a scene's episodes from one viewpoint, those that the scratch store lacks."""

    def __init__(self, scene: Scene, view: Viewpoint) -> None:
        self._scene, self._view = scene, view

    @cached_property
    def _renderer(self) -> ParallelRenderer:
        return ParallelRenderer(self._scene, self._view, cores(), segment=True)

    def repeat(self, store: zarrs.Store, repeat: int) -> Path:
        """The scratch folder of one repeat's finished frames."""
        view = {"scene": self._scene.name, "theta_deg": self._view.theta, "phi_deg": self._view.phi}
        facts = {**view, "mujoco": mujoco.__version__}

        def make(results: Path, running: Path) -> None:
            episodes, frames = store.shape("reward")
            what = f"frames {self._scene.name} ({self._view.theta:g}°, {self._view.phi:g}°), repeat {repeat}"
            with Progress(episodes * frames, what) as progress:
                arrays = render(self._renderer, store, repeat, progress)
                zarrs.write(results / REPEAT, zarrs.FRAMES, arrays, facts)

        cache_key: dict[str, Any] = {"inputs": digest_files([store.place(repeat)]), "facts": facts}
        cache_key |= {"code": code_digest("frames"), "scene": self._scene.cache_key}
        return finished("frames", repeat, make, **cache_key)


if __name__ == "__main__":
    entry(main)
