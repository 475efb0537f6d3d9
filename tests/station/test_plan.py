"""The plan of a session: balanced over participants, paired within one, the same for the same seed."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.scene import Scene, load_scene
from pipeline.station.params import candidates
from pipeline.station.plan import Block, generator, orders, planned_blocks, task_order, view_order

SCENES = ("panda_1dof", "panda_2dof", "panda_2dof_obstacle")
TRIALS = 4


@pytest.fixture(scope="module")
def scenes() -> dict[str, Scene]:
    return {name: load_scene(name) for name in SCENES}


@pytest.fixture(scope="module")
def views() -> dict[str, dict[str, Viewpoint]]:
    return {name: candidates(name) for name in SCENES}


@pytest.fixture(scope="module")
def participants(scenes: dict[str, Scene], views: dict[str, dict[str, Viewpoint]]) -> list[tuple[Block, ...]]:
    made: list[tuple[Block, ...]] = []
    for number in range(12):
        made.append(planned_blocks(scenes, views, made, TRIALS, generator(1, number)))
    return made


@pytest.mark.parametrize("n", range(1, 8))
def test_each_name_stands_equally_often_at_each_place_and_before_each_other(n: int) -> None:
    rows = orders([str(k) for k in range(n)])
    for place in range(n):
        assert len(set(Counter(row[place] for row in rows).values())) == 1
    follows = Counter(pair for row in rows for pair in pairwise(row))
    assert len(follows) == n * (n - 1) and len(set(follows.values())) <= 1


def test_orders_of_tasks_and_views_are_used_equally_often(participants: list[tuple[Block, ...]]) -> None:
    assert set(Counter(task_order(blocks) for blocks in participants).values()) == {2}
    for scene in SCENES:
        assert set(Counter(view_order(blocks, scene) for blocks in participants).values()) == {6}


def test_after_any_number_of_participants_no_order_is_two_behind(
    participants: list[tuple[Block, ...]],
) -> None:
    for number in range(1, len(participants) + 1):
        for scene in SCENES:
            used = Counter(view_order(blocks, scene) for blocks in participants[:number])
            counts = [used[order] for order in orders(next(iter(used)))]
            assert max(counts) - min(counts) <= 1


def test_all_views_of_a_task_have_the_same_starts_and_targets(participants: list[tuple[Block, ...]]) -> None:
    for blocks in participants:
        for scene in SCENES:
            own = [
                {(t.target_index, t.start_m, t.target_m) for t in block.trials}
                for block in blocks
                if block.scene == scene
            ]
            assert len(own) == 2 and own[0] == own[1] and len(own[0]) == TRIALS


def test_the_target_is_each_candidate_once(
    participants: list[tuple[Block, ...]], scenes: dict[str, Scene]
) -> None:
    for block in participants[0]:
        points = scenes[block.scene].params.target.candidates_m
        assert sorted(t.target_index for t in block.trials) == [0, 1, 2, 3]
        assert all(t.target_m == pytest.approx(points[t.target_index]) for t in block.trials)


def test_trials_are_numbered_over_the_session(participants: list[tuple[Block, ...]]) -> None:
    for blocks in participants:
        assert [t.trial for block in blocks for t in block.trials] == list(range(1, 6 * TRIALS + 1))
        assert [block.block for block in blocks] == [1, 2, 3, 4, 5, 6]


def test_the_seed_decides_everything(
    scenes: dict[str, Scene], views: dict[str, dict[str, Viewpoint]]
) -> None:
    first, again, other = (
        planned_blocks(scenes, views, [], TRIALS, generator(seed, 0)) for seed in (1, 1, 2)
    )
    assert first == again and first != other


def test_practice_is_drawn_apart(scenes: dict[str, Scene]) -> None:
    draws = generator(1, 0).random(8), generator(1, 0, practice=True).random(8)
    assert not np.isclose(*draws).any()
