"""Push: the puck moves by contact only, starts where it is drawn, and slides in its plane."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.expert import Expert
from pipeline.sim.tasks.push import push_aim
from pipeline.sim.worlds import Worlds
from tests.examples import example

COUNT = 32


def begun(count: int = COUNT, seed: int = 1) -> tuple[Worlds, Episodes]:
    worlds, episodes = (
        Worlds(example("push"), count),
        draw_episodes(example("push"), count, np.random.default_rng(seed)),
    )
    worlds.reset(episodes)
    return worlds, episodes


def test_the_puck_starts_where_it_is_drawn_and_the_tip_is_away_from_it() -> None:
    worlds, episodes = begun(300)
    puck = example("push").params.task.puck
    assert (episodes.drawn >= puck.low_m).all() and (episodes.drawn <= puck.high_m).all()
    assert (np.ptp(episodes.drawn, axis=0) > 0.9 * np.subtract(puck.high_m, puck.low_m)).all()
    np.testing.assert_allclose(worlds.point[:, :2], episodes.drawn, atol=1e-9)
    away = np.linalg.norm(worlds.tip[:, :2] - worlds.point[:, :2], axis=1)
    assert away.min() >= example("push").params.task.contact_m


def test_without_contact_the_puck_rests_and_with_it_it_moves() -> None:
    worlds, episodes = begun()
    back = np.tile([-1.0, 0.0], (COUNT, 1))  # away from it
    for _ in range(20):
        worlds.step(back)
    assert np.abs(worlds.point[:, :2] - episodes.drawn).max() < 1e-9
    expert, moved = Expert(example("push")), np.zeros(COUNT)
    worlds.reset(episodes)
    for _ in range(20):
        before, clear = worlds.point, np.linalg.norm(worlds.tip - worlds.point, axis=1)
        worlds.step(expert(worlds.state))
        step = np.linalg.norm(worlds.point - before, axis=1)
        assert step[clear > 0.11].max(initial=0.0) < 1e-9  # the tip makes no 4 cm a frame
        moved += step
    assert moved.min() > 0.03


def test_the_puck_stays_in_its_plane_and_stops_when_let_go() -> None:
    worlds, _ = begun()
    expert = Expert(example("push"))
    for _ in range(8):
        worlds.step(expert(worlds.state))
    np.testing.assert_allclose(worlds.point[:, 2], 0.03, atol=1e-9)
    for _ in range(8):
        worlds.step(np.tile([-1.0, 0.0], (COUNT, 1)))
    before = worlds.point
    worlds.step(np.tile([-1.0, 0.0], (COUNT, 1)))
    assert np.abs(worlds.point - before).max() < 1e-4


@pytest.mark.parametrize("seed", [2, 3])
def test_the_expert_brings_every_puck_to_its_goal(seed: int) -> None:
    worlds, _ = begun(64, seed)
    expert = Expert(example("push"))
    for _ in range(example("push").frames):
        worlds.step(expert(worlds.state))
    assert worlds.error.max() < 0.02


def test_it_goes_round_the_puck_and_not_through_it() -> None:
    """A point that does as it is told, from in front of the puck, keeps its distance until it is behind."""
    puck, goal = np.zeros((1, 2)), np.array([[1.0, 0.0]])
    tip = np.array([[0.1, 0.001]])
    for _ in range(200):
        away = float(np.linalg.norm(tip))
        assert away > 0.05 or tip[0, 0] < 0
        if tip[0, 0] < 0 and abs(tip[0, 1]) < 0.02:
            break
        way = push_aim(tip, puck, goal, 0.05) - tip
        tip = tip + way * min(1.0, 0.003 / np.linalg.norm(way))
    assert tip[0, 0] < -0.04


def test_who_sees_nothing_believes_the_puck_before_its_tip() -> None:
    task = example("push").task
    carried = task.imagined(np.array([[0.4, 0.0], [0.5, 0.0], [0.6, 0.0]]))
    np.testing.assert_allclose(carried(np.array([[0.3, 0.0, 0.05]])), [[0.5, 0.0, 0.05]])
    np.testing.assert_allclose(carried(np.array([[0.48, 0.0, 0.05]]))[0, 0], 0.48 + task.contact_m)
    np.testing.assert_allclose(carried(np.array([[0.30, 0.0, 0.05]]))[0, 0], 0.48 + task.contact_m)
