"""What geometry alone says against a place for the camera, before anything is trained there."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.placement.params import Forbidden, PlacementParams
from pipeline.placement.places import Place
from pipeline.rendering.visibility import refuse_hidden_targets, to_pixels
from pipeline.sim.boxes import crosses
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import Scene, with_camera
from pipeline.storage.candidates import Candidate


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
    """Looks at each place once, and keeps what speaks against it.

    Args:
        scene: compiled.
        where: what is declared.
    """

    def __init__(self, scene: Scene, where: PlacementParams) -> None:
        self._scene, self._where = scene, where
        self._looked: dict[Place, str | None] = {}

    def allowed(self, place: Place) -> bool:
        """Whether a camera can stand there."""
        if place not in self._looked:
            self._looked[place] = self.fault(Candidate(scene=self._scene.name, **place._asdict()))
        return self._looked[place] is None

    def fault(self, candidate: Candidate) -> str | None:
        """Why no camera can stand there; ``None`` where nothing speaks against it."""
        scene = with_camera(self._scene, candidate.distance_m, candidate.fov_deg)
        return fault(scene, candidate.viewpoint, self._where.forbidden)

    def within(self, candidate: Candidate) -> bool:
        """Whether a candidate lies in the declared ranges; without one its camera must be the scene's."""
        camera, where = self._scene.params.camera, self._where
        (low, high), (least, most) = where.theta_deg, where.phi_deg
        near, far = where.distance_m or (camera.distance_m, camera.distance_m)
        narrow, wide = where.fov_deg or (camera.fov_deg, camera.fov_deg)
        if (candidate.theta - low) % 360 > high - low or not least <= candidate.phi <= most:
            return False
        return near <= candidate.distance_m <= far and narrow <= candidate.fov_deg <= wide

    @property
    def faults(self) -> dict[Place, str]:
        """What was looked at and ruled out, and why."""
        return {place: why for place, why in self._looked.items() if why is not None}
