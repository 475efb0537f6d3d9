"""Places: which are allowed, how more of them join those there are, and how cameras differ among them."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.placement.places import Place, allowed_places, places, spread
from pipeline.placement.sphere import Direction, lattice
from pipeline.sim.params import Camera
from tests.placement.declared import HALF

CAMERA = Camera(look_at_m=(0, 0, 0), distance_m=1.4, fov_deg=40, front_deg=0)


def at(*directions: Direction) -> list[Place]:
    return places(HALF, CAMERA, directions)


def test_places_that_are_not_allowed_make_room_for_others() -> None:
    rng = np.random.default_rng(1)
    right = allowed_places(HALF, CAMERA, 24, lambda place: place.theta > 0, rng)
    assert len(right) >= 24 and all(place.theta > 0 for place in right)
    assert allowed_places(HALF, CAMERA, 24, lambda place: False, rng) == []


@pytest.mark.parametrize("by", ["lattice", "grid", "random"])
def test_each_rule_gives_as_many_as_are_wanted(by: str) -> None:
    where = HALF.model_copy(update={"by": by})
    found = allowed_places(where, CAMERA, 20, lambda place: True, np.random.default_rng(1))
    assert len(found) >= 20 and len({place.direction for place in found}) == len(found)


def test_more_places_later_leave_the_earlier_ones() -> None:
    first = lattice(HALF, 12)
    more = spread(first, at(*lattice(HALF, 24)), 24)
    assert len({*first, *(place.direction for place in more)}) == 24


def test_each_added_place_is_the_farthest_from_those_there() -> None:
    chosen = spread([(0, 0)], at((10, 0), (90, 0), (45, 0), (-20, 0)), 3)
    assert [place.direction for place in chosen] == [(90, 0), (45, 0)]


def test_spread_gives_what_there_is_where_places_are_few() -> None:
    assert spread([], at((0, 0), (20, 0)), 5) in (at((0, 0), (20, 0)), at((20, 0), (0, 0))[::-1])
    assert spread([(0, 0)], at((0, 0)), 5) == []


def test_without_ranges_every_camera_is_the_scene_s() -> None:
    assert {(place.distance_m, place.fov_deg) for place in at(*lattice(HALF, 30))} == {(1.4, 40)}


def test_distances_and_fields_of_view_fill_their_ranges_evenly_and_apart() -> None:
    where = HALF.model_copy(update={"distance_m": (1.0, 2.0), "fov_deg": (30, 60)})
    found = places(where, CAMERA, lattice(where, 400))
    distances, fovs = np.array([(place.distance_m, place.fov_deg) for place in found]).T
    assert np.array_equal(distances, distances.round(2)) and np.array_equal(fovs, fovs.round())
    counts, _, _ = np.histogram2d(distances, fovs, bins=4, range=[(1, 2), (30, 60)])
    assert counts.sum() == 400 and counts.min() > 15 and counts.max() < 35


def test_pans_are_those_from_which_a_camera_can_be_turned_both_ways() -> None:
    around = HALF.model_copy(update={"theta_deg": (0, 360)})
    pans = [place.theta for place in places(around, CAMERA, lattice(around, 60))]
    assert min(pans) >= -180 and max(pans) < 180
    assert sorted(pan % 360 for pan in pans) == sorted(theta % 360 for theta, _ in lattice(around, 60))


def test_one_range_alone_leaves_the_other_to_the_scene() -> None:
    where = HALF.model_copy(update={"distance_m": (1.0, 2.0)})
    found = places(where, CAMERA, lattice(where, 24))
    assert {place.fov_deg for place in found} == {40} and len({place.distance_m for place in found}) == 24
