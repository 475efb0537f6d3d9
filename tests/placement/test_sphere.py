"""Directions on the sphere: areas, edges, and reproducible draws."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.placement.params import PlacementParams
from pipeline.placement.sphere import grid, lattice, random
from pipeline.stats.surface import unit_vectors
from tests.placement.declared import HALF

AROUND = PlacementParams(
    candidates=24,
    by="lattice",
    theta_deg=(-180, 180),
    phi_deg=(-85, 85),
    distance_m=None,
    fov_deg=None,
    forbidden=(),
)


def declared(**changes: object) -> PlacementParams:
    return HALF.model_copy(update=changes)


@pytest.mark.parametrize("where", [HALF, AROUND])
@pytest.mark.parametrize("make", [lattice, lambda w, n: random(w, n, np.random.default_rng(3))])
def test_equal_areas_have_as_many_directions(where: PlacementParams, make) -> None:
    """Archimedes: on the sphere, the area of a band is its share of sin φ."""
    found = np.array(make(where, 4000), dtype=float)
    height = np.sin(np.radians(found[:, 1]))
    low, high = np.sin(np.radians(where.phi_deg))
    counts, _ = np.histogram((height - low) / (high - low), bins=5, range=(0, 1))
    assert counts == pytest.approx(np.full(5, len(found) / 5), rel=0.15)
    pans, _ = np.histogram(found[:, 0], bins=6, range=where.theta_deg)
    assert pans == pytest.approx(np.full(6, len(found) / 6), rel=0.15)


@pytest.mark.parametrize("count", [6, 24, 48, 96])
def test_the_lattice_has_no_two_directions_close_together(count: int) -> None:
    vectors = unit_vectors(lattice(AROUND, count))
    cosines = vectors @ vectors.T - 2 * np.eye(len(vectors))
    nearest = np.degrees(np.arccos(cosines.max(axis=1)))
    even = np.degrees(2 * (1 / count) ** 0.5)  # the radius of a cap of each one's area, doubled
    assert nearest.min() > 0.5 * even


def test_directions_lie_in_the_ranges() -> None:
    for made in (lattice(HALF, 50), grid(HALF, 50), random(HALF, 50, np.random.default_rng(1))):
        theta, phi = np.array(made).T
        assert theta.min() >= -90 and theta.max() <= 90 and phi.min() >= 0 and phi.max() <= 75


@pytest.mark.parametrize("count", [4, 12, 24, 50])
def test_the_grid_has_its_edges_and_at_least_as_many(count: int) -> None:
    found = grid(HALF, count)
    assert len(found) >= count and len(set(found)) == len(found)
    theta, phi = np.array(found).T
    assert {theta.min(), theta.max()} == {-90, 90}
    assert {phi.min(), phi.max()} == ({0, 75} if len(set(phi)) > 1 else {phi.min()})


def test_a_grid_all_around_has_no_direction_twice() -> None:
    vectors = unit_vectors(grid(AROUND, 60))
    assert (vectors @ vectors.T - 2 * np.eye(len(vectors))).max() < 1 - 1e-9


@pytest.mark.parametrize("place", [(30.0, 30.0), (-90.0, 90.0)])
def test_one_pan_alone_or_one_tilt_alone_is_a_line(place: tuple[float, float]) -> None:
    line = declared(theta_deg=place, phi_deg=(20, 20) if place[0] < 0 else (0, 75))
    for made in (lattice(line, 8), grid(line, 8)):
        assert len(made) == 8


def test_a_random_set_begins_like_a_smaller_one() -> None:
    few, many = (random(HALF, n, np.random.default_rng(5)) for n in (10, 20))
    assert many[:10] == few


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"theta_deg": (10, 0)}, "must not be above"),
        ({"theta_deg": (-200, 200)}, "more than 360"),
        ({"distance_m": (2, 1)}, "must not be above"),
        ({"fov_deg": (0, 40)}, "greater than 0"),
        ({"fov_deg": (42.5, 50)}, "whole degrees"),
        ({"distance_m": (1.005, 2)}, "whole centimetres"),
        ({"phi_deg": (0, 7.5)}, "whole degrees"),
        ({"fov_deg": (42.5, 50)}, "whole degrees"),
        ({"distance_m": (1.005, 2)}, "whole centimetres"),
        ({"phi_deg": (0, 7.5)}, "whole degrees"),
        ({"candidates": 1}, "greater than or equal to 2"),
        ({"by": "hand"}, "lattice"),
        ({"phi_deg": (0, 90)}, "less than 90"),
    ],
)
def test_what_is_not_valid_is_told(change: dict, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        PlacementParams.model_validate(HALF.model_dump() | change)
