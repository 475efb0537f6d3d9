"""A film of one episode: large for people, and beside it what the world model saw."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import Renderer
from pipeline.rendering.visibility import PICTURE_SIZE
from pipeline.sim.scene import Scene
from pipeline.storage.artefacts import writing

_SIDE = 192  # of each of the two pictures, pixels
_QUALITY = 60  # of WebP, 0 to 100
_MS_PER_S = 1000


def write_clip(path: Path, scene: Scene, view: Viewpoint, qpos: np.ndarray, target_m: np.ndarray) -> None:
    """Writes an animated WebP that plays at the scene's own pace.

    Args:
        path: where to.
        scene: the compiled scene.
        view: where the camera stands.
        qpos: generalised positions, shape (t, nq).
        target_m: the target at the same times, shape (t, 3), m.
    """
    large = Renderer(scene, view, len(qpos), size=_SIDE, antialias=2).render(qpos, target_m)
    small = Renderer(scene, view, len(qpos)).render(qpos, target_m)
    times = _SIDE // PICTURE_SIZE
    seen = small.repeat(times, axis=1).repeat(times, axis=2)
    first, *rest = (Image.fromarray(frame) for frame in np.concatenate([large, seen], axis=2))
    frame_s = scene.params.substeps * scene.params.timestep_s
    with writing(path) as aside:
        first.save(
            aside,
            format="WEBP",
            save_all=True,
            append_images=rest,
            duration=round(frame_s * _MS_PER_S),
            loop=0,
            quality=_QUALITY,
            method=4,
        )
