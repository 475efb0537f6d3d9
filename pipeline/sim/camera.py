"""Where the camera of a viewpoint stands."""

from __future__ import annotations

import math

import numpy as np

from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.params import Camera


def camera_to_world(camera: Camera, view: Viewpoint) -> tuple[np.ndarray, np.ndarray]:
    """The camera's pose in MuJoCo's convention (it looks along -z, x is right, y is up).

    Returns:
        ``(position_m, rotation)``: shapes (3,) and (3, 3); columns of the rotation are the
        camera's x, y and z axes in the world frame.
    """
    theta, phi = math.radians(view.theta + camera.front_deg), math.radians(view.phi)
    back = np.array([math.cos(phi) * math.cos(theta), math.cos(phi) * math.sin(theta), math.sin(phi)])
    right = np.array([-math.sin(theta), math.cos(theta), 0.0])
    rotation = np.stack([right, np.cross(back, right), back], axis=1)
    return np.asarray(camera.look_at_m) + camera.distance_m * back, rotation
