"""Places for cameras: directions on the sphere, each with a distance and a field of view."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from pipeline.placement.params import PlacementParams
from pipeline.placement.sphere import Direction, grid, lattice, random
from pipeline.sim.params import Camera
from pipeline.stats.surface import unit_vectors

# Fractions of multiples of these fill the square evenly, whichever number of them is taken: powers of the
# inverse of the plastic number, M. Roberts' R2 sequence.
_STEPS = (1 / 1.324717957244746, 1 / 1.324717957244746**2)
_DENSEST = 64  # times as many places as candidates are wanted; then the allowed part is too small for them


class Place(NamedTuple):
    """Where a camera may stand, and how wide it sees.

    Attributes:
        theta: pan, degrees.
        phi: tilt, degrees.
        distance_m: from the point that it looks at.
        fov_deg: its vertical field of view.
    """

    theta: int
    phi: int
    distance_m: float
    fov_deg: float

    @property
    def direction(self) -> Direction:
        """Pan and tilt, degrees."""
        return self.theta, self.phi


Allowed = Callable[[Place], bool]


def places(where: PlacementParams, camera: Camera, directions: Sequence[Direction]) -> list[Place]:
    """Directions with distances (whole centimetres) and fields of view (whole degrees) over their ranges.

    Where no range is declared the scene's ``camera`` says them. Pans are those from -180 to 179.
    """
    made = []
    for number, (pan, phi) in enumerate(directions):
        theta = (pan + 180) % 360 - 180  # so that a camera turned by some degrees has a valid pan, too
        of_distance, of_fov = ((0.5 + number * step) % 1.0 for step in _STEPS)
        distance_m, fov_deg = camera.distance_m, camera.fov_deg
        if where.distance_m is not None:
            distance_m = round(_within(where.distance_m, of_distance), 2)
        if where.fov_deg is not None:
            fov_deg = float(round(_within(where.fov_deg, of_fov)))
        made.append(Place(theta, phi, distance_m, fov_deg))
    return made


def _within(bounds: tuple[float, float], share: float) -> float:
    low, high = bounds
    return low + (high - low) * share


def allowed_places(
    where: PlacementParams, camera: Camera, count: int, allowed: Allowed, rng: np.random.Generator
) -> list[Place]:
    """At least ``count`` allowed places by the declared rule, of as coarse a set as has them.

    Fewer only where even a set of 64 times as many has fewer.
    """
    found: list[Place] = []
    seed = rng.integers(2**32)
    for wanted in range(count, _DENSEST * count + 1, max(1, count // 24)):
        match where.by:
            case "lattice":
                directions = lattice(where, wanted)
            case "grid":
                directions = grid(where, wanted)
            case _:
                directions = random(where, wanted, np.random.default_rng(seed))
        found = [one for one in places(where, camera, directions) if allowed(one)]
        if len(found) >= count:
            break
    return found


def spread(kept: Sequence[Direction], offered: Sequence[Place], count: int) -> list[Place]:
    """Those of the ``offered`` places that make ``kept`` up to ``count`` and lie farthest from all before.

    So more candidates later leave the earlier ones where they are. Each choice is the place whose nearest
    direction is farthest (maximin); the first of equals.
    """
    taken = set(kept)
    pool = [one for one in offered if one.direction not in taken]
    if not kept and len(pool) == count:
        return pool
    near = np.full(len(pool), -np.inf)  # cosine of the angle to the nearest direction that is taken
    vectors = unit_vectors([one.direction for one in pool])
    for direction in kept:
        near = np.maximum(near, vectors @ unit_vectors([direction])[0])
    chosen: list[Place] = []
    while len(kept) + len(chosen) < count and len(pool):
        place = int(near.argmin())
        chosen.append(pool.pop(place))
        near = np.delete(np.maximum(near, vectors @ vectors[place]), place)
        vectors = np.delete(vectors, place, axis=0)
    return chosen
