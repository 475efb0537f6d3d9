"""How much of the task's motion survives projection: the image Jacobian of the tip over the controlled axes.

Source: S. Hutchinson, G. D. Hager and P. I. Corke, IEEE Trans. Robot. Autom. 12 (1996) 651-670 (image
Jacobian); its singular values as a measure of what a camera resolves: B. J. Nelson and P. K. Khosla,
Int. J. Robot. Res. 14 (1995) 255-269.
"""

from __future__ import annotations

import numpy as np

from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import Scene


def image_jacobian(scene: Scene, view: Viewpoint, points_m: np.ndarray, size: int) -> np.ndarray:
    """How points move in a square picture per metre along the controlled axes.

    Args:
        scene: the compiled scene.
        view: where the camera stands.
        points_m: (n, 3), world frame, in front of the camera.
        size: side of the picture, pixels.

    Returns:
        (n, 2, axes): columns and rows, pixels per metre.
    """
    position, rotation = camera_to_world(scene.params.camera, view)
    focal = size / 2 / np.tan(np.radians(scene.params.camera.fov_deg) / 2)
    inside = (points_m - position) @ rotation  # the camera looks along its -z
    depth = -inside[:, 2:]
    moved = rotation[list(scene.axes)]  # (axes, 3): each controlled axis in the camera's frame
    across = (moved[None, :, :2] + inside[:, None, :2] / depth[:, None] * moved[None, :, 2:]) / depth[:, None]
    return np.asarray(focal * np.array([1.0, -1.0])[:, None] * across.swapaxes(1, 2))


def singular_values(jacobian: np.ndarray) -> np.ndarray:
    """Of Jacobians (n, 2, axes): (n, min(2, axes)), pixels per metre, largest first.

    A picture has two dimensions: of three axes it resolves two directions at best, so a third value is
    always zero and left out.
    """
    return np.asarray(np.linalg.svd(jacobian, compute_uv=False))
