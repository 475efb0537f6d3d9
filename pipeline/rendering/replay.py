"""A scene's recorded episodes as one viewpoint shows them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from pipeline.contract import zarrs
from pipeline.contract.parts import InParts
from pipeline.contract.progress import Progress
from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import ParallelRenderer, Renderer, target_pixels_unhidden
from pipeline.rendering.visibility import PICTURE_SIZE
from pipeline.sim.scene import Scene

_LARGE = 512  # side of the picture for people, pixels


def render(
    renderer: ParallelRenderer, store: zarrs.Store, repeat: int, progress: Progress
) -> dict[str, np.ndarray | InParts]:
    """One repeat's arrays of the layout :data:`pipeline.contract.zarrs.FRAMES`; pictures are drawn in parts.

    Args:
        renderer: renders what the viewpoint shows, targets marked.
        store: the episodes, layout :data:`pipeline.contract.zarrs.ROLLOUTS`.
        repeat: which of the store's.
        progress: is told of every picture.
    """
    qpos, target = store.repeat("qpos", repeat), store.repeat("target", repeat)
    episodes, frames = qpos.shape[:2]
    pixels = np.zeros((episodes, frames), np.int32)  # filled as pictures are drawn

    def draw(place: slice) -> np.ndarray:
        flat, targets = qpos[place].reshape(-1, qpos.shape[-1]), np.repeat(target[place], frames, axis=0)
        rgb, seen = renderer.render(flat, targets, progress.advance)
        pixels[place] = seen.reshape(-1, frames)
        return rgb.reshape(-1, frames, *rgb.shape[1:])

    rgb = InParts((episodes, frames, PICTURE_SIZE, PICTURE_SIZE, 3), draw)
    free = target_pixels_unhidden(renderer.scene, renderer.view, qpos[:, 0], target)
    same = {name: store.repeat(name, repeat) for name in ("tip", "action", "reward", "target")}
    return {"rgb": rgb, "target_pixels": pixels, "target_pixels_free": free, **same}


def write_pictures(folder: Path, scene: Scene, view: Viewpoint, store: zarrs.Store) -> None:
    """The first frame of repeat 0: ``view.png`` for people, ``view_64.png`` as the world model sees it."""
    qpos, target = store.repeat("qpos", 0)[:1, 0], store.repeat("target", 0)[:1]
    large = Renderer(scene, view, 1, size=_LARGE, antialias=2).render(qpos, target)[0]
    small = Renderer(scene, view, 1).render(qpos, target)[0]
    Image.fromarray(large).save(folder / "view.png", optimize=True)
    Image.fromarray(small).save(folder / "view_64.png")
