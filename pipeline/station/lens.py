"""A camera whose lens is shifted: rows of a wide picture as the first rows of a square one."""

from __future__ import annotations

import mujoco
import numpy as np
import warp as wp

from pipeline.rendering import buffers, raytracer
from pipeline.rendering.ray_packets import SIDE


def band_view(
    model: mujoco.MjModel, data: mujoco.MjData, camera: int, size: tuple[int, int], first: int, rows: int
) -> tuple[raytracer.View, wp.array]:
    """A square view whose first ``rows`` rows are those from ``first`` on of a picture, and its rays.

    Args:
        size: width and height of the picture, pixels; the width is a multiple of 4, as are the rows.

    Returns:
        The view, and the rays of its rows (3, r), world frame, packet by packet, padded to the whole square.
    """
    width, height = size
    rotation = data.cam_xmat[camera].reshape(3, 3)
    focal = height / 2 / np.tan(np.radians(model.cam_fovy[camera]) / 2)
    across = (np.arange(width) + 0.5 - width / 2) / focal
    down = (np.arange(rows) + first + 0.5 - height / 2) / focal
    rays = np.stack(np.broadcast_arrays(across, -down[:, None], -1.0), axis=-1) @ rotation.T
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    blocks = rays.reshape(rows // SIDE, SIDE, width // SIDE, SIDE, 3)
    view, _ = buffers.view_of(model, data, camera, SIDE)  # origin and light
    # what the camera sees in direction (x, y, z) is to be found `shift` rows lower in the square, in whose
    # middle row width / 2 rows are above it: y is sheared along z
    shift = (height / 2 - first) - width / 2
    sheared = rotation @ np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, shift / focal, 1.0]])
    view.rotation, view.focal, view.samples = wp.mat33(*sheared.reshape(-1)), focal, width
    return view, wp.array(blocks.transpose(4, 0, 2, 1, 3).reshape(3, -1), dtype=float)
