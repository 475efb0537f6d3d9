"""Fixed viewpoints: pan θ and tilt φ about the scene's look-at point (paper Figs 6 and 9)."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import Field

from pipeline.contract.errors import BelvedereError
from pipeline.contract.params import Section
from pipeline.sim.params import Camera


class Viewpoint(Section):
    """A fixed camera viewpoint.

    Attributes:
        scene: the scene's name.
        theta: pan about the vertical, degrees; 0 looks along x at the y-z plane from the front.
        phi: tilt above the horizon, degrees, strictly between -90 and 90.
    """

    scene: str
    theta: float
    phi: Annotated[float, Field(gt=-90, lt=90)]


def viewpoint(scene: str, theta_deg: float, phi_deg: float) -> Viewpoint:
    """A checked viewpoint.

    Raises:
        BelvedereError: an angle is no finite number, or φ is not within (-90, 90) degrees.
    """
    for name, angle in (("theta", theta_deg), ("phi", phi_deg)):
        if not math.isfinite(angle):
            raise BelvedereError(
                f"viewpoint {name} = {angle} (of scene {scene}) is not valid; it is a number of degrees."
            )
    if not -90 < phi_deg < 90:
        raise BelvedereError(
            f"viewpoint phi = {phi_deg:g} (of scene {scene}) is not valid; the tilt above the horizon "
            "lies strictly between -90 and 90 degrees."
        )
    return Viewpoint(scene=scene, theta=theta_deg, phi=phi_deg)


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
