"""`python -m pipeline.rendering.preview`: a viewpoint's picture, large and as the world model sees it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from pipeline.contract import params, seeds
from pipeline.contract.viewpoints import viewpoint
from pipeline.rendering.renderer import Renderer
from pipeline.rendering.visibility import PICTURE_SIZE
from pipeline.sim.environment import environment
from pipeline.sim.scene import load_scene
from pipeline.storage.artefacts import writing
from pipeline.storage.stage import entry

_LARGE = 512  # side of the picture for people, pixels


def main(*, scene: str, theta: float, phi: float, out: Path) -> None:
    """Writes one picture: the start of a drawn episode, large, and beside it the 64 × 64 enlarged."""
    compiled, view = load_scene(scene), viewpoint(scene, theta, phi)
    env = environment(compiled, seeds.generator(params.seed(), 0, seeds.Stream.ROLLOUTS))
    env.reset()
    qpos, target = env.physics.data.qpos[None].astype(np.float32), env.physics.target()[None]
    large = Renderer(compiled, view, 1, size=_LARGE, antialias=2).render(qpos, target)[0]
    small = Renderer(compiled, view, 1).render(qpos, target)[0]
    both = np.concatenate(
        [large, np.kron(small, np.ones((_LARGE // PICTURE_SIZE,) * 2 + (1,), np.uint8))], axis=1
    )
    with writing(out) as aside, aside.open("wb") as file:
        Image.fromarray(both).save(file, format="png")
    print(f"wrote {out}")


if __name__ == "__main__":
    entry(main)
