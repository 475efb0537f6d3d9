"""A scene's recorded episodes as one viewpoint shows them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from pipeline.contract.progress import Progress
from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import ParallelRenderer, Renderer, target_pixels_unhidden
from pipeline.rendering.visibility import PICTURE_SIZE
from pipeline.sim.scene import Scene
from pipeline.storage import zarrs
from pipeline.storage.parts import InParts
from pipeline.storage.positions import target_by_frame

_LARGE = 512  # side of the picture for people, pixels


def render(
    renderer: ParallelRenderer, store: zarrs.Store, repeat: int, progress: Progress
) -> dict[str, np.ndarray | InParts]:
    """One repeat's arrays of the layout :data:`pipeline.storage.zarrs.FRAMES`; pictures are drawn in parts.

    Args:
        renderer: renders what the viewpoint shows, targets marked.
        store: the episodes, layout :data:`pipeline.storage.zarrs.ROLLOUTS`.
        repeat: which of the store's.
        progress: is told of every picture.
    """
    qpos, target = store.repeat("qpos", repeat), target_by_frame(store, repeat)
    episodes, frames = qpos.shape[:2]
    pixels = np.zeros((episodes, frames), np.int32)  # filled as pictures are drawn

    def draw(place: slice) -> np.ndarray:
        flat, targets = qpos[place].reshape(-1, qpos.shape[-1]), target[place].reshape(-1, 3)
        rgb, seen = renderer.render(flat, targets, progress.advance)
        pixels[place] = seen.reshape(-1, frames)
        return rgb.reshape(-1, frames, *rgb.shape[1:])

    rgb = InParts((episodes, frames, PICTURE_SIZE, PICTURE_SIZE, 3), draw)
    free = _unhidden(renderer, qpos, target)
    names = ["tip", "action", "reward", "target", *filter(store.has, zarrs.TASK)]
    same = {name: store.repeat(name, repeat) for name in names}
    return {"rgb": rgb, "target_pixels": pixels, "target_pixels_free": free, **same}


def _unhidden(renderer: ParallelRenderer, qpos: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Pixels of each episode's target with nothing in front of it, their mean if it moves: (n,), int32."""
    times = slice(None) if renderer.scene.task.moves else slice(1)
    places = target[:, times]
    at = qpos[:, times].reshape(-1, qpos.shape[-1])
    free = target_pixels_unhidden(renderer.scene, renderer.view, at, places.reshape(-1, 3))
    return np.round(free.reshape(places.shape[:2]).mean(axis=1)).astype(np.int32)


def write_pictures(folder: Path, scene: Scene, view: Viewpoint, store: zarrs.Store) -> None:
    """The first frame of repeat 0: ``view.png`` for people, ``view_64.png`` as the world model sees it."""
    qpos, target = store.repeat("qpos", 0)[:1, 0], target_by_frame(store, 0)[:1, 0]
    large = Renderer(scene, view, 1, size=_LARGE, antialias=2).render(qpos, target)[0]
    small = Renderer(scene, view, 1).render(qpos, target)[0]
    Image.fromarray(large).save(folder / "view.png", optimize=True)
    Image.fromarray(small).save(folder / "view_64.png")
