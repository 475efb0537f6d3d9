"""What a view lets an operator resolve: the error of a look, from the camera alone.

A point that is seen gives three numbers: column u and row v in the picture, and, by the size s of the thing
around it whose diameter D it knows, its depth: s = f D / z, with the focal length f in pixels and the depth z
along the optical axis. Each edge is placed with the standard deviation b (``blur_px``), so u and v err by b
and s, the distance of two edges, by √2 b. For a small move along the controlled axes the three change by
J = ∂(u, v, s) / ∂x, and the least-squares estimate of the place on those axes has the covariance

    Σ = b² (Jᵀ diag(1, 1, 1/2) J)⁻¹.

Across the line of sight that is a standard deviation of about b z / f, one pixel projected to the point's
depth; along it √2 b z² / (f D), √2 z / D times as much: twelve times at 0.85 m with D = 0.1 m. The way from
tip to target errs by both places' errors, so its covariance is the sum. Both count as things of the target's
diameter. Who hides whom, shading, and all else that tells people of depth is left out: this is geometry.
"""

from __future__ import annotations

import numpy as np

from pipeline.baselines.motion import image_jacobian
from pipeline.contract.viewpoints import Viewpoint
from pipeline.scripted.params import OperatorParams
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import Scene

_WEIGHTS = np.array([1.0, 1.0, 0.5])  # of column, row and size, whose variance is twice an edge's


def look_error(
    scene: Scene, view: Viewpoint, params: OperatorParams, tip_m: np.ndarray, target_m: np.ndarray
) -> np.ndarray:
    """The error that a view adds to a look at the way from tip to target.

    Args:
        scene, view: which camera.
        params: its ``picture_px`` and ``blur_px``.
        tip_m, target_m: (n, 3), m, in front of the camera.

    Returns:
        Factors L of the covariances L Lᵀ on the controlled axes: (n, axes, axes), m.
    """
    covariance = sum(place_covariance(scene, view, params.picture_px, at) for at in (tip_m, target_m))
    return np.asarray(params.blur_px * np.linalg.cholesky(covariance))


def place_covariance(scene: Scene, view: Viewpoint, picture_px: int, points_m: np.ndarray) -> np.ndarray:
    """Of points (n, 3) on the controlled axes, for edges placed to within one pixel: (n, axes, axes), m²."""
    jacobian = np.concatenate(
        [image_jacobian(scene, view, points_m, picture_px), _growth(scene, view, picture_px, points_m)],
        axis=1,
    )
    return np.linalg.inv(np.einsum("nki,k,nkj->nij", jacobian, _WEIGHTS, jacobian))


def _growth(scene: Scene, view: Viewpoint, picture_px: int, points_m: np.ndarray) -> np.ndarray:
    """How the size of the target there changes along the controlled axes: (n, 1, axes), pixels per metre."""
    position, rotation = camera_to_world(scene.params.camera, view)
    focal = picture_px / 2 / np.tan(np.radians(scene.params.camera.fov_deg) / 2)
    towards = rotation[:, 2]  # the camera looks along its -z
    depth = -(points_m - position) @ towards
    size = focal * 2 * scene.params.target.radius_m / depth
    return np.asarray((size / depth)[:, None, None] * towards[list(scene.axes)][None, None, :])
