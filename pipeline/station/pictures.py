"""Which renderer draws the live picture, and how large: what is fast enough here, found by trying."""

from __future__ import annotations

import io
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from PIL import Image

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.scene import Scene, initial_data
from pipeline.station.bands import RayTracer
from pipeline.station.opengl import MujocoRenderer, NoOpenGL
from pipeline.station.params import RendererName

DRAWN_WITHIN = 0.6  # of a control frame; the rest is for encoding, sending and the page
_SHARES = (1.0, 0.75, 0.5, 0.25)  # of the asked width and height, for the ray tracer
_SAMPLES = (4, 0)  # a pixel, for MuJoCo's renderer
_TRIES = 7
_QUALITY = 90


class Renderer(Protocol):
    """Draws one viewpoint."""

    @property
    def name(self) -> str:
        """For the data: ``mujoco-egl``, ``mujoco-glfw`` or ``ray tracer``."""

    def draw(self, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """A picture, uint8 (height, width, 3), of a world (nq,), (3,), m; its memory is used again."""

    def close(self) -> None:
        """Frees what it holds."""


@dataclass(frozen=True)
class Choice:
    """A way of drawing.

    Attributes:
        name: of the renderer.
        size: width and height, pixels.
        samples: a pixel, for MuJoCo's renderer; 0 is one.
        milliseconds: that a picture took when it was tried.
    """

    name: str
    size: tuple[int, int]
    samples: int
    milliseconds: float


def renderer_of(choice: Choice, scene: Scene, view: Viewpoint, threads: int) -> Renderer:
    """The chosen renderer before a viewpoint.

    Raises:
        NoOpenGL: MuJoCo's renderer was chosen and there is no OpenGL.
    """
    if choice.name == RayTracer.name:
        return RayTracer(scene, view, choice.size, threads)
    return MujocoRenderer(scene, view, choice.size, choice.samples)


def choose(
    scene: Scene, view: Viewpoint, size: tuple[int, int], wanted: RendererName, frame_s: float, threads: int
) -> Choice:
    """The first that draws a picture in :data:`DRAWN_WITHIN` of a control frame; if none does, the fastest.

    MuJoCo's own renderer is tried first, with several samples a pixel and with one; then the ray tracer, as
    large as asked and then smaller. An OpenGL without a graphics card is often slower than the ray tracer.

    Raises:
        BelvedereError: MuJoCo's renderer is wanted and there is no OpenGL.
    """
    tried: list[Choice] = []
    for make, samples, tried_size in _ways(scene, view, size, wanted, threads):
        try:
            renderer = make()
        except NoOpenGL as error:
            if wanted == "mujoco":
                raise BelvedereError(
                    f"station.renderer = 'mujoco', but there is no OpenGL here ({error}); install EGL "
                    "(Debian: libegl1, libgl1-mesa-dri) or take 'auto' or 'ray tracer'."
                ) from None
            continue
        found = Choice(renderer.name, tried_size, samples, _milliseconds(renderer, scene))
        renderer.close()
        if found.milliseconds <= 1000 * DRAWN_WITHIN * frame_s:
            return found
        tried.append(found)
    return min(tried, key=lambda choice: choice.milliseconds)


def _ways(
    scene: Scene, view: Viewpoint, size: tuple[int, int], wanted: RendererName, threads: int
) -> Iterator[tuple[Callable[[], Renderer], int, tuple[int, int]]]:
    if wanted != "ray tracer":
        for samples in _SAMPLES:
            yield partial(MujocoRenderer, scene, view, size, samples), samples, size
    if wanted != "mujoco":
        for share in _SHARES:
            smaller = int(size[0] * share), int(size[1] * share)
            yield partial(RayTracer, scene, view, smaller, threads), 0, smaller


def _milliseconds(renderer: Renderer, scene: Scene) -> float:
    """What a picture takes: the median of some, after one that may compile."""
    qpos, target = initial_data(scene).qpos.copy(), np.array(scene.params.target.candidates_m[0])
    renderer.draw(qpos, target)
    taken = []
    for _ in range(_TRIES):
        begin_s = time.perf_counter()
        renderer.draw(qpos, target)
        taken.append(1000 * (time.perf_counter() - begin_s))
    return float(np.median(taken))


def encoded(picture: np.ndarray) -> bytes:
    """A picture, uint8 (height, width, 3), as JPEG."""
    buffer = io.BytesIO()
    Image.fromarray(picture).save(buffer, format="jpeg", quality=_QUALITY)
    return buffer.getvalue()
