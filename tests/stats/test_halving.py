"""Halving and the race of finalists, by hand and on simulated maps (decision.md's figures)."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.search import row
from pipeline.stats.halving import final, halve, least_trainings
from pipeline.stats.race import Rules

RULES = Rules(first=3, most=20, tolerance=0.05, probability=0.008)


def repeats(*rows: list[float]) -> list[np.ndarray]:
    return [np.array(own, dtype=float) for own in rows]


def test_by_hand() -> None:
    values = repeats([0.9, 0.1], [0.8, 0.8], [0.1], [0.7, 0.9], [0.2])
    found = halve(values, 2)
    assert [(one.repeats, one.kept) for one in found.rounds] == [(1, [0, 1, 3]), (2, [1, 3])]
    assert found.done and found.active == [1, 3] and found.needed == {}


@pytest.mark.parametrize(("views", "finalists"), [(24, 6), (48, 6), (7, 3), (4, 6)])
def test_the_least_trainings_are_those_up_to_the_first_look(views: int, finalists: int) -> None:
    values = [np.empty(0)] * views
    while needed := (found := halve(values, finalists)).needed or final(values, found, RULES)[1]:
        values = [np.arange(needed.get(view, len(own))) + view for view, own in enumerate(values)]
    assert least_trainings(views, finalists, RULES.first) == sum(map(len, values))


def test_a_view_that_lacks_a_repeat_is_waited_for() -> None:
    found = halve(repeats([0.9], [0.8, 0.8], [0.7], []), 2)
    assert found.rounds == [] and found.needed == {3: 1} and not found.done


@pytest.mark.parametrize(
    ("views", "sizes"), [(48, [24, 12, 6]), (24, [12, 6]), (13, [7, 6]), (6, []), (2, [])]
)
def test_each_round_keeps_half_and_never_fewer_than_the_finalists(views: int, sizes: list[int]) -> None:
    rng = np.random.default_rng(1)
    found = halve([rng.random(4) for _ in range(views)], 6)
    assert [len(one.kept) for one in found.rounds] == sizes
    assert len(found.active) == min(views, 6)


def test_repeats_beyond_a_round_decide_nothing_in_it() -> None:
    values = repeats([0.9, 0.9], [0.8, 0.8], [0.1, 5.0], [0.2, 5.0])
    assert halve(values, 2).active == [0, 1]


def test_the_race_counts_the_repeats_after_the_halving_only() -> None:
    chosen = [0.0, 0.0]
    high, low = [0.9, 0.91, 0.9, 0.92], [0.1, 0.12, 0.1, 0.11]
    values = repeats([*chosen, *low], [*chosen, *high], *[[-1.0, -1.0]] * 4)
    halving = halve(values, 2)
    assert [len(one.kept) for one in halving.rounds] == [3, 2]
    race, lacking = final(values, halving, RULES)
    assert lacking == {} and race is not None
    assert race.state == "alone" and halving.active[race.leader] == 1


def test_the_race_waits_for_its_first_repeats() -> None:
    halving = halve(repeats([0.9], [0.8], [0.1], [0.2]), 2)
    race, lacking = final(repeats([0.9], [0.8], [0.1], [0.2]), halving, RULES)
    assert race is None and lacking == {0: 4, 1: 4}


@pytest.mark.parametrize("kind", ["smooth", "edge"])
def test_simulated_searches_cost_and_err_as_decided(kind: str) -> None:
    """decision.md: halving 48, then a race at .1: 115 to 128 trainings, .96 to .99 within .05 of the best."""
    found = row(kind, 0.06, 0.1, 60, seed=4)
    assert 105 <= found["trainings"] <= 132
    assert found["within .05"] >= 0.9 and found["regret"] <= 0.02
    assert found["wrong"] <= 0.05
