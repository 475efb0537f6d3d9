"""Replays a scene's episodes and renders them from one viewpoint."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from PIL import Image

from pipeline.contract import zarrs
from pipeline.contract.artefacts import writing
from pipeline.contract.machine import cores
from pipeline.contract.progress import Progress
from pipeline.contract.stage import entry
from pipeline.sim.camera import Viewpoint, viewpoint
from pipeline.sim.images import Gallery, Images, target_pixels_unhidden
from pipeline.sim.scene import Scene, load_scene
from pipeline.sim.sight import refuse_hidden_targets

_LARGE = 512  # side of the picture for people, pixels


def main(*, scene: str, theta: float, phi: float, rollouts: Path, out: Path, picture: Path) -> None:
    """Writes the frames' store (layout :data:`pipeline.contract.zarrs.FRAMES`) and two pictures of the view.

    ``picture`` becomes a folder with ``view.png`` (for people) and ``view_64.png`` (64 × 64, as the
    world model sees it).
    """
    compiled, view = load_scene(scene), viewpoint(scene, theta, phi)
    refuse_hidden_targets(compiled, view)
    store = zarrs.Store(rollouts, zarrs.ROLLOUTS, f"rollouts@{scene}")
    gallery = Gallery(compiled, view, cores(), segment=True)
    episodes, frames = store.shape("reward")[1:]
    with Progress(store.repeats * episodes * frames, f"frames {scene} ({theta:g}°, {phi:g}°)") as progress:
        blocks = [render(compiled, view, gallery, store, r, progress) for r in range(store.repeats)]
    arrays = {name: np.stack([block[name] for block in blocks]) for name in zarrs.FRAMES}
    facts = {"scene": scene, "theta_deg": theta, "phi_deg": phi, "mujoco": mujoco.__version__}
    zarrs.write(out, zarrs.FRAMES, arrays, facts)
    _write_pictures(compiled, view, store, blocks[0]["rgb"][0, 0], picture)


def render(
    scene: Scene, view: Viewpoint, gallery: Gallery, store: zarrs.Store, repeat: int, progress: Progress
) -> dict[str, np.ndarray]:
    """One repeat's arrays of the frames layout, without their leading axis."""
    qpos, target = store.repeat("qpos", repeat), store.repeat("target", repeat)
    frames = qpos.shape[1]
    flat = qpos.reshape(-1, qpos.shape[-1])
    rgb, pixels = gallery.render(flat, np.repeat(target, frames, axis=0), progress.advance)
    rgb, pixels = (a.reshape(*qpos.shape[:2], *a.shape[1:]) for a in (rgb, pixels))
    free = target_pixels_unhidden(scene, view, qpos[:, 0], target)
    same = {name: store.repeat(name, repeat) for name in ("tip", "action", "reward", "target")}
    return {"rgb": rgb, "target_pixels": pixels, "target_pixels_free": free, **same}


def _write_pictures(scene: Scene, view: Viewpoint, store: zarrs.Store, small: np.ndarray, out: Path) -> None:
    """The first episode's first frame of repeat 0."""
    qpos, target = store.repeat("qpos", 0)[:1, 0], store.repeat("target", 0)[:1]
    large = Images(scene, view, 1, size=_LARGE, antialias=2).render(qpos, target)[0]
    with writing(out) as folder:
        folder.mkdir()
        Image.fromarray(large).save(folder / "view.png", optimize=True)
        Image.fromarray(small).save(folder / "view_64.png")


if __name__ == "__main__":
    entry(main)
