"""Directions on a part of the sphere: Fibonacci lattice, grid of pan and tilt, and random ones.

A direction is (θ, φ), pan and tilt in whole degrees: nobody mounts a camera more exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pipeline.placement.params import PlacementParams
from pipeline.stats.surface import unit_vectors

Direction = tuple[int, int]
Allowed = Callable[[Direction], bool]
GOLDEN = (1 + 5**0.5) / 2
_DENSEST = 64  # times as many places as candidates are wanted; then the allowed part is too small for them


def lattice(where: PlacementParams, count: int) -> list[Direction]:
    """Fibonacci's lattice: sin φ in equal steps, so that each has the same area, θ by the golden ratio.

    R. Swinbank and R. J. Purser, Q. J. R. Meteorol. Soc. 132 (2006) 1769-1793, on a part of the sphere.
    """
    steps = (np.arange(count) + 0.5) / count
    return _directions(where, steps, np.arange(count) / GOLDEN % 1.0)


def grid(where: PlacementParams, count: int) -> list[Direction]:
    """About ``count`` directions in rows of equal tilt, as far apart in pan as in tilt; at least ``count``.

    Edges are taken, but for the last pan where the range goes all around.
    """
    wide, high = (b - a for a, b in (where.theta_deg, where.phi_deg))
    rows = count if high else 1
    if wide and high:
        rows = max(1, round((count * high / wide) ** 0.5))
    columns = -(-count // rows)
    pans = np.linspace(*where.theta_deg, columns, endpoint=not where.all_around)
    tilts = np.linspace(*where.phi_deg, rows) if rows > 1 else [sum(where.phi_deg) / 2]
    return list(dict.fromkeys((round(theta), round(phi)) for phi in tilts for theta in pans))


def random(where: PlacementParams, count: int, rng: np.random.Generator) -> list[Direction]:
    """Directions drawn evenly by area; the first ones are the same for any larger count."""
    draws = rng.random((count, 2))
    return _directions(where, draws[:, 0], draws[:, 1])


def _directions(where: PlacementParams, of_height: np.ndarray, of_pan: np.ndarray) -> list[Direction]:
    low, high = np.sin(np.radians(where.phi_deg))
    phi = np.degrees(np.arcsin(low + (high - low) * of_height))
    theta = where.theta_deg[0] + (where.theta_deg[1] - where.theta_deg[0]) * of_pan
    pairs = zip(np.rint(theta).astype(int).tolist(), np.rint(phi).astype(int).tolist(), strict=True)
    return list(dict.fromkeys(pairs))


def allowed_places(
    where: PlacementParams, count: int, allowed: Allowed, rng: np.random.Generator
) -> list[Direction]:
    """At least ``count`` allowed directions by the declared rule, of as coarse a set as has them.

    Fewer only where even a set of 64 times as many has fewer.
    """
    found: list[Direction] = []
    seed = rng.integers(2**32)
    for places in range(count, _DENSEST * count + 1, max(1, count // 24)):
        match where.by:
            case "lattice":
                made = lattice(where, places)
            case "grid":
                made = grid(where, places)
            case _:
                made = random(where, places, np.random.default_rng(seed))
        found = [one for one in made if allowed(one)]
        if len(found) >= count:
            break
    return found


def spread(kept: Sequence[Direction], places: Sequence[Direction], count: int) -> list[Direction]:
    """``kept`` and, up to ``count`` in all, those of ``places`` that lie farthest from all chosen before.

    So more candidates later leave the earlier ones where they are. Each choice is the place whose nearest
    chosen direction is farthest (maximin); the first of equals.
    """
    chosen = list(kept)
    pool = [one for one in places if one not in chosen]
    if not chosen and len(pool) == count:
        return pool
    near = np.full(len(pool), -np.inf)  # cosine of the angle to the nearest chosen one
    vectors = unit_vectors(pool)
    for one in chosen:
        near = np.maximum(near, vectors @ unit_vectors([one])[0])
    while len(chosen) < count and len(pool):
        place = int(near.argmin())
        chosen.append(pool.pop(place))
        near = np.delete(np.maximum(near, vectors @ vectors[place]), place)
        vectors = np.delete(vectors, place, axis=0)
    return chosen
