"""How much of tip and target a viewpoint shows, in given states, by casting rays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import target_pixels_unhidden
from pipeline.rendering.visibility import PICTURE_SIZE, Sight, to_pixels
from pipeline.sim.scene import Scene


@dataclass(frozen=True)
class Visibility:
    """Means over states.

    Attributes:
        seen_share: visible share of the pixels that a sphere of the target's size would fill there with
            nothing in front of it; 0 in states in which it is out of the picture.
        in_frame_share: share of the states in which its centre lies in the picture.
        pixels: visible pixels of that sphere.
    """

    seen_share: float
    in_frame_share: float
    pixels: float


def visibility(scene: Scene, view: Viewpoint, qpos: np.ndarray, points_m: np.ndarray) -> Visibility:
    """What is seen of a sphere at points (n, 3), one in each state (n, nq)."""
    seen = Sight(scene, len(qpos)).target_pixels(view, qpos, points_m)
    free = target_pixels_unhidden(scene, view, qpos, points_m)
    places = to_pixels(scene, view, points_m, PICTURE_SIZE)
    inside = ((places >= 0) & (places < PICTURE_SIZE)).all(axis=1)
    share = np.where(free > 0, np.minimum(seen / np.maximum(free, 1), 1.0), 0.0)
    return Visibility(float(share.mean()), float(inside.mean()), float(seen.mean()))
