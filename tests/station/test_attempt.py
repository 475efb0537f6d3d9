"""Time, distance and path against closed forms, in a world that moves exactly as it is told."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.scene import Scene, load_scene
from pipeline.station.attempt import ABORTED, GRASPED, TIMEOUT, Attempt
from pipeline.station.inputs import SILENCE_S, Mailbox, Push
from pipeline.station.params import station_params
from pipeline.station.sticks import Sticks

FRAME_S = 0.04
STEP_M = 0.01  # a frame at a full stick: 0.25 m/s
FULL_UP = np.array([0.0, -1.0])
START, TARGET = np.array([0.5, 0.0, 0.20]), np.array([0.5, 0.03, 0.40])


class Exact:
    """A world whose tip makes just the displacement that is asked for."""

    def __init__(self, scene: Scene) -> None:
        self.scene = SimpleNamespace(action_size=scene.action_size, axes=scene.axes)
        self._step_m = scene.params.displacement_m
        self.tip, self.target, self.closed, self.touches = START.copy(), TARGET, 0, True

    def step(self, action: np.ndarray) -> None:
        self.tip = self.tip.copy()
        self.tip[list(self.scene.axes)] += action * self._step_m

    def close(self) -> None:
        self.closed += 1

    def homeward(self) -> np.ndarray | None:
        way = (START - self.tip)[list(self.scene.axes)]
        return None if np.linalg.norm(way) < 1e-9 else np.clip(way / self._step_m, -1, 1)


class Hands:
    """Pushes and buttons, by the clock of the test."""

    def __init__(self, attempt: Attempt) -> None:
        self.attempt, self.now_s, self.seq, self._mailbox = attempt, 100.0, 0, Mailbox()

    def frames(self, count: int, left: np.ndarray, right: np.ndarray, *buttons: str) -> None:
        for name in buttons:
            self._mailbox.button(name, self.now_s)
        for _ in range(count):
            self.seq += 1
            self._mailbox.push(Push(self.seq, self.now_s, left, right, "gamepad", "a pad"))
            self.attempt.advance(self._mailbox.take(self.now_s), self.now_s)
            self.now_s += FRAME_S


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("panda_2dof")


@pytest.fixture
def hands(scene: Scene) -> Hands:
    sticks = Sticks(scene, Viewpoint(scene=scene.name, theta=0, phi=0), station_params())
    return Hands(Attempt(Exact(scene), sticks, FRAME_S, limit_s=4.0))  # type: ignore[arg-type]


REST = np.zeros(2)


def test_time_distance_and_path_are_those_of_uniform_motion(hands: Hands) -> None:
    hands.frames(5, REST, REST)
    hands.frames(20, REST, FULL_UP)  # 0.2 m up
    hands.frames(10, REST, REST)
    hands.frames(1, REST, REST, "a")
    measured = hands.attempt.measured
    assert measured is not None and measured.outcome == GRASPED
    assert measured.time_s == pytest.approx(30 * FRAME_S)
    assert measured.wall_s == pytest.approx(30 * FRAME_S)
    assert measured.path_m == pytest.approx(20 * STEP_M)
    assert measured.tip_m == pytest.approx([0.5, 0.0, 0.40])
    assert measured.distance_m == pytest.approx(0.03)
    assert measured.inputs == 20
    assert measured.real_time_factor == pytest.approx(1.0)
    assert measured.frames == 35 and measured.rows.shape == (36, 9)


def test_a_path_there_and_back_is_twice_as_long_and_its_distance_is_that_from_the_start(hands: Hands) -> None:
    hands.frames(1, REST, REST)
    hands.frames(8, np.array([1.0, 0.0]), REST)
    hands.frames(8, np.array([-1.0, 0.0]), REST)
    hands.frames(1, REST, REST, "a")
    measured = hands.attempt.measured
    assert measured is not None
    assert measured.path_m == pytest.approx(16 * STEP_M)
    assert measured.distance_m == pytest.approx(float(np.linalg.norm(START - TARGET)))


def test_half_a_stick_beyond_the_dead_zone_is_half_as_fast(hands: Hands) -> None:
    zone = station_params().dead_zone
    hands.frames(1, REST, REST)
    hands.frames(10, REST, FULL_UP * (zone + (1 - zone) / 2))
    assert hands.attempt.world.tip[2] - START[2] == pytest.approx(10 * STEP_M / 2)


def test_time_runs_from_the_first_input_only(hands: Hands) -> None:
    hands.frames(200, REST, REST)  # longer than the limit
    assert hands.attempt.measured is None and not hands.attempt.begun
    hands.frames(1, REST, FULL_UP)
    assert hands.attempt.begun


def test_what_is_pushed_from_the_trial_before_moves_nothing_until_it_was_let_go(hands: Hands) -> None:
    hands.frames(10, REST, FULL_UP)
    assert hands.attempt.world.tip == pytest.approx(START) and not hands.attempt.begun
    hands.frames(1, REST, REST)
    hands.frames(1, REST, FULL_UP)
    assert hands.attempt.world.tip[2] > START[2]


def test_a_counts_from_the_first_input_on(hands: Hands) -> None:
    hands.frames(3, REST, REST, "a")
    assert hands.attempt.measured is None
    hands.frames(1, REST, FULL_UP)
    hands.frames(1, REST, REST, "a")
    assert hands.attempt.measured is not None and hands.attempt.world.closed == 1


def test_nothing_moves_after_a(hands: Hands) -> None:
    hands.frames(1, REST, REST)
    hands.frames(3, REST, FULL_UP)
    hands.frames(1, REST, FULL_UP, "a")
    there = hands.attempt.world.tip.copy()
    first = hands.attempt.measured
    hands.frames(10, REST, FULL_UP, "a")
    assert hands.attempt.world.tip == pytest.approx(there) and hands.attempt.measured is first


def test_the_limit_ends_it_without_time_and_distance(hands: Hands) -> None:
    hands.frames(1, REST, REST)
    hands.frames(150, REST, np.array([0.0, -0.2]))
    measured = hands.attempt.measured
    assert measured is not None and measured.outcome == TIMEOUT
    assert measured.time_s is measured.wall_s is measured.distance_m is None and not measured.touched
    assert measured.frames == 1 + round(4.0 / FRAME_S)


def test_what_is_broken_off_keeps_its_path(hands: Hands) -> None:
    hands.frames(1, REST, REST)
    hands.frames(5, REST, FULL_UP)
    hands.attempt.abort(hands.now_s)
    measured = hands.attempt.measured
    assert measured is not None and measured.outcome == ABORTED and measured.distance_m is None
    assert measured.path_m == pytest.approx(5 * STEP_M) and measured.device == "a pad"


def test_start_leads_back_and_the_sticks_rest_meanwhile(hands: Hands) -> None:
    hands.frames(1, REST, REST)
    hands.frames(20, REST, FULL_UP)
    hands.frames(1, REST, FULL_UP, "start")
    hands.frames(4, REST, FULL_UP)
    assert hands.attempt.world.tip == pytest.approx(START)
    hands.frames(1, REST, REST)
    hands.frames(2, REST, FULL_UP)
    assert hands.attempt.world.tip[2] == pytest.approx(START[2] + 2 * STEP_M)
    assert hands.attempt.measured is None


def test_a_silent_page_lets_go_of_the_sticks() -> None:
    mailbox = Mailbox()
    mailbox.push(Push(7, 10.0, REST, FULL_UP, "gamepad", "a pad"))
    assert mailbox.take(10.0).now.right == pytest.approx(FULL_UP)
    assert mailbox.take(10.0 + 0.9 * SILENCE_S).now.right == pytest.approx(FULL_UP)
    late = mailbox.take(10.0 + 1.1 * SILENCE_S).now
    assert late.right == pytest.approx(REST) and late.seq == 7


def test_a_mailbox_gives_everything_once_and_in_order() -> None:
    mailbox = Mailbox()
    for seq in range(1, 4):
        mailbox.push(Push(seq, 1.0))
    mailbox.button("a", 1.0)
    taken = mailbox.take(1.0)
    assert [push.seq for push in taken.pushes] == [1, 2, 3] and taken.buttons == (("a", 1.0),)
    again = mailbox.take(1.0)
    assert again.pushes == again.buttons == () and again.now is taken.now
