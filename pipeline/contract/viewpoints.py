"""Fixed viewpoints in params.yaml: pan θ and tilt φ about a scene's look-at point (paper Figs 6 and 9)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

from pydantic import Field

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError

NAME = (
    r"^[A-Za-z0-9][A-Za-z0-9_-]*$"  # of scenes and viewpoints: they name files, stages and parts of the page
)
STUDY = "study"  # the branch of the section ``viewpoint``


class Viewpoint(params.Section):
    """A fixed camera viewpoint.

    Attributes:
        scene: the scene's name.
        theta: pan about the vertical, degrees; 0 looks along x at the y-z plane from the front.
        phi: tilt above the horizon, degrees.
    """

    scene: Annotated[str, Field(pattern=NAME)]
    theta: Annotated[float, Field(ge=-360, le=360)]
    phi: Annotated[float, Field(gt=-90, lt=90)]

    @property
    def direction(self) -> tuple[float, float]:
        """θ and φ, degrees."""
        return self.theta, self.phi

    @property
    def place(self) -> tuple[str, float, float]:
        """What is the same for the same picture: a full turn of θ changes nothing."""
        return self.scene, self.theta % 360, self.phi


def named_viewpoints(path: Path = params.PARAMS_FILE) -> dict[str, Viewpoint]:
    """The viewpoints of params.yaml by branch: the candidates, then ``study``.

    Raises:
        BelvedereError: one is not valid, or its name is not.
    """
    candidates = params.mapping("viewpoints", path=path)
    for key in candidates:
        if not re.fullmatch(NAME, str(key)) or key == STUDY:
            raise params.invalid(
                path, "a name below viewpoints", key, f"it has letters, digits, _ and - and is not {STUDY}"
            )
    found = {key: params.section(Viewpoint, "viewpoints", key, path=path) for key in candidates}
    return {**found, STUDY: params.section(Viewpoint, "viewpoint", path=path)}


def viewpoint(scene: str, theta_deg: float, phi_deg: float) -> Viewpoint:
    """A checked viewpoint.

    Raises:
        BelvedereError: an angle is out of its range or no number.
    """
    for name, angle, valid, range_ in (
        ("theta", theta_deg, abs(theta_deg) <= 360, "the pan lies within -360 and 360 degrees"),
        (
            "phi",
            phi_deg,
            abs(phi_deg) < 90,
            "the tilt above the horizon lies strictly between -90 and 90 degrees",
        ),
    ):
        if not valid:  # NaN is neither
            raise BelvedereError(f"viewpoint {name} = {angle:g} (of scene {scene}) is not valid; {range_}.")
    return Viewpoint(scene=scene, theta=theta_deg, phi=phi_deg)
