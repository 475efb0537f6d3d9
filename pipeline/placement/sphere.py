"""Directions on a part of the sphere: Fibonacci lattice, grid of pan and tilt, and random ones.

A direction is (θ, φ), pan and tilt in whole degrees: nobody mounts a camera more exactly.
"""

from __future__ import annotations

import numpy as np

from pipeline.placement.params import PlacementParams

Direction = tuple[int, int]
GOLDEN = (1 + 5**0.5) / 2


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
