"""What geometry alone says against a place for the camera, before anything is trained there."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.placement.params import Forbidden, PlacementParams
from pipeline.placement.sphere import Direction
from pipeline.rendering.visibility import refuse_hidden_targets, to_pixels
from pipeline.sim.boxes import crosses
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import Scene


def fault(scene: Scene, view: Viewpoint, forbidden: Sequence[Forbidden]) -> str | None:
    """Why no camera can stand there, in words; ``None`` where nothing speaks against it.

    Looked at: boxes that are forbidden (the camera must lie outside, and none may stand between it and a
    target position), the picture's edge (a target at each corner of the workspace must be in the picture),
    and what is fixed in the scene (no target position may be hidden wholly).
    """
    camera, _ = camera_to_world(scene.params.camera, view)
    for box in forbidden:
        if _inside(camera, box):
            return f"the camera would stand in {box.name}"
    targets = np.asarray(scene.params.target.candidates_m)
    for box in forbidden:
        if _between(camera, targets, box).any():
            return f"{box.name} stands between the camera and a target"
    if not _in_picture(scene, view, workspace_corners(scene)).all():
        return "a target at a corner of the workspace is out of the picture"
    try:
        refuse_hidden_targets(scene, view)
    except BelvedereError:
        return "something fixed in the scene hides a target wholly"
    return None


def workspace_corners(scene: Scene) -> np.ndarray:
    """(n, 3) the workspace's corners, each once, m."""
    box = scene.params.workspace
    return np.unique(list(itertools.product(*zip(box.low_m, box.high_m, strict=True))), axis=0)


def _inside(point_m: np.ndarray, box: Forbidden) -> bool:
    return bool((np.abs(point_m - np.asarray(box.center_m)) <= np.asarray(box.half_size_m)).all())


def _between(camera_m: np.ndarray, ends_m: np.ndarray, box: Forbidden) -> np.ndarray:
    middle, half = np.asarray(box.center_m), np.asarray(box.half_size_m)
    return crosses(np.broadcast_to(camera_m, ends_m.shape), ends_m, middle - half, middle + half)


def _in_picture(scene: Scene, view: Viewpoint, points_m: np.ndarray) -> np.ndarray:
    """(n,) whether points lie before the camera and within the picture."""
    position, rotation = camera_to_world(scene.params.camera, view)
    before = (points_m - position) @ rotation[:, 2] < 0
    pixels = to_pixels(scene, view, points_m, 2)
    return np.asarray(before & (np.abs(pixels - 1) <= 1).all(axis=1))


class Screen:
    """Looks at each direction once, and keeps what speaks against it.

    Args:
        scene: compiled.
        where: what is declared.
    """

    def __init__(self, scene: Scene, where: PlacementParams) -> None:
        self._scene, self._where = scene, where
        self._looked: dict[Direction, str | None] = {}

    def allowed(self, direction: Direction) -> bool:
        """Whether a camera can stand there."""
        if direction not in self._looked:
            view = Viewpoint(scene=self._scene.name, theta=direction[0], phi=direction[1])
            self._looked[direction] = self.fault(view)
        return self._looked[direction] is None

    def fault(self, view: Viewpoint) -> str | None:
        """Why no camera can stand there; ``None`` where nothing speaks against it."""
        return fault(self._scene, view, self._where.forbidden)

    def within(self, view: Viewpoint) -> bool:
        """Whether the direction lies in the declared ranges."""
        (low, high), (least, most) = self._where.theta_deg, self._where.phi_deg
        return (view.theta - low) % 360 <= high - low and least <= view.phi <= most

    @property
    def faults(self) -> dict[Direction, str]:
        """What was looked at and ruled out, and why."""
        return {direction: why for direction, why in self._looked.items() if why is not None}
