"""What params.yaml says of where a search may place cameras."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pipeline.contract.params import Section
from pipeline.sim.params import Box

Pan = Annotated[float, Field(ge=-360, le=360)]
Tilt = Annotated[float, Field(gt=-90, lt=90)]
Distance = Annotated[float, Field(gt=0, le=1000)]
FieldOfView = Annotated[float, Field(gt=0, lt=170)]
MOST_CANDIDATES = 500


class Forbidden(Box):
    """A box in which no camera stands and through which none looks: a wall, a rack, a person's place."""

    name: Annotated[str, Field(min_length=1, max_length=40)]


class PlacementParams(Section):
    """Section ``searches.SCENE.placement``.

    Places are whole degrees and centimetres, and so are the bounds.

    Attributes:
        candidates: how many are placed, after those that geometry rules out.
        by: ``lattice`` (Fibonacci's, the same area for each), ``grid`` (of pan and tilt) or ``random``.
        theta_deg: lowest and highest pan; 360 apart is all around.
        phi_deg: lowest and highest tilt above the horizon.
        distance_m: nearest and farthest from the point that cameras look at; null is the scene's.
        fov_deg: narrowest and widest field of view; null is the scene's.
        forbidden: boxes, world frame, m.
    """

    candidates: Annotated[int, Field(ge=2, le=MOST_CANDIDATES)]
    by: Literal["lattice", "grid", "random"]
    theta_deg: tuple[Pan, Pan]
    phi_deg: tuple[Tilt, Tilt]
    distance_m: tuple[Distance, Distance] | None
    fov_deg: tuple[FieldOfView, FieldOfView] | None
    forbidden: tuple[Forbidden, ...]

    @model_validator(mode="after")
    def _ordered(self) -> PlacementParams:
        degrees = ((name, "degrees", 0) for name in ("theta_deg", "phi_deg", "fov_deg"))
        for name, unit, digits in (*degrees, ("distance_m", "centimetres", 2)):
            low, high = getattr(self, name) or (0, 0)
            if low > high:
                raise ValueError(f"{name}: {low:g} must not be above {high:g}")
            if any(round(value, digits) != value for value in (low, high)):
                raise ValueError(f"{name}: {low:g} and {high:g} must be whole {unit}")
        if self.theta_deg[1] - self.theta_deg[0] > 360:
            raise ValueError("theta_deg: more than 360 degrees would place cameras twice")
        return self

    @property
    def all_around(self) -> bool:
        """Whether the lowest and the highest pan are the same direction."""
        return self.theta_deg[1] - self.theta_deg[0] == 360
