"""The scripted operator's law: reaction, speed, looks, and when it closes the gripper."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from pipeline.scripted.law import ScriptedOperator
from pipeline.scripted.params import OperatorParams
from tests.support import ROOT

FRAME_S = 0.04
DECLARED = OperatorParams(**yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))["operator"])


def params(**changes: float) -> OperatorParams:
    return DECLARED.model_copy(update={"noise_m": 0.0, **changes})


def operator(asked: OperatorParams, count: int = 1, axes: int = 2, seed: int = 1) -> ScriptedOperator:
    return ScriptedOperator(asked, FRAME_S, count, axes, np.random.default_rng(seed))


def follow(
    asked: OperatorParams, way: np.ndarray, frames: int, seed: int = 1, view_m: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A point that moves as told: ways left (frame, n, axes), speeds and grasps (frame, n)."""
    who, way = operator(asked, *way.shape, seed), way.copy()
    ways, speeds, grasps = [], [], []
    for _ in range(frames):
        act = who.act(way, way, view_m)
        way = way - act.velocity_m_s * FRAME_S
        ways.append(way)
        speeds.append(np.linalg.norm(act.velocity_m_s, axis=1))
        grasps.append(act.grasps)
    return np.array(ways), np.array(speeds), np.array(grasps)


def test_it_rests_for_its_reaction_and_never_exceeds_its_speed() -> None:
    asked = params(reaction_s=0.24)
    _, speeds, _ = follow(asked, np.array([[0.3, -0.1]]), 100)
    assert (speeds[:6] == 0).all() and speeds[6, 0] == pytest.approx(asked.speed_m_s)
    assert speeds.max() <= asked.speed_m_s + 1e-12


def test_without_errors_it_comes_to_the_target_grasps_there_and_stays() -> None:
    ways, speeds, grasps = follow(params(), np.array([[0.2, 0.1], [0.01, 0.0]]), 250)
    assert np.linalg.norm(ways[-1], axis=1).max() < DECLARED.grasp_within_m
    assert grasps[-1].all() and (np.diff(grasps.astype(int), axis=0) >= 0).all()
    for world in range(2):
        first = int(grasps[:, world].argmax())
        assert (speeds[first:, world] == 0).all()
    assert grasps[:, 1].argmax() < grasps[:, 0].argmax()  # who is nearer is done sooner


def test_it_grasps_once_it_has_believed_to_be_near_for_the_dwell() -> None:
    """The tip stands still; the look of frame 0 takes effect after the reaction."""
    asked = params(reaction_s=0.2, dwell_s=0.4)
    who, near = operator(asked), np.array([[0.5 * asked.grasp_within_m, 0.0]])
    told = [bool(who.act(near, near).grasps[0]) for _ in range(30)]
    assert told.index(True) == 5 + 10 - 1
    far = np.array([[1.5 * asked.grasp_within_m, 0.0]])
    who = operator(asked)
    assert not any(who.act(far, far).grasps[0] for _ in range(100))


def test_it_heads_where_the_way_leads_and_grasps_by_what_is_left() -> None:
    who, up, left = operator(params()), np.array([[0.0, 0.2]]), np.array([[0.2, 0.0]])
    acts = [who.act(up, left) for _ in range(40)]
    assert acts[-1].velocity_m_s[0, 0] == 0 and acts[-1].velocity_m_s[0, 1] > 0
    assert not acts[-1].grasps[0]


def test_between_looks_it_goes_by_the_last_one() -> None:
    asked = params(noise_m=0.05, look_s=0.2, reaction_s=0.0)
    who, way = operator(asked), np.array([[0.03, 0.02]])
    velocities = np.array([who.act(way, way).velocity_m_s[0] for _ in range(20)])
    for begin in range(0, 20, 5):
        assert (velocities[begin : begin + 5] == velocities[begin]).all()
    assert (velocities[0] != velocities[5]).all()


def test_looks_err_as_declared_and_as_the_view_adds() -> None:
    asked = params(noise_m=0.003, look_s=FRAME_S, reaction_s=0.0, speed_m_s=2.0, gain_per_s=1.0)
    factor = np.array([[0.004, 0.0], [0.002, 0.001]])
    who, way = operator(asked, 400), np.full((400, 2), 0.5)
    seen = np.concatenate([who.act(way, way, np.tile(factor, (400, 1, 1))).velocity_m_s for _ in range(50)])
    wanted = 0.003**2 * np.eye(2) + factor @ factor.T
    assert np.cov(seen.T) == pytest.approx(wanted, abs=1e-6)
    assert seen.mean(axis=0) == pytest.approx(0.5, abs=2e-4)


def test_the_worse_it_sees_the_longer_it_takes_and_the_farther_off_it_ends() -> None:
    ways = np.random.default_rng(5).uniform(-0.15, 0.15, (200, 2))
    ends = {}
    for blur in (0.0, 0.005, 0.01):
        left, _, grasps = follow(DECLARED, ways, 1500, view_m=np.tile(blur * np.eye(2), (200, 1, 1)))
        assert grasps[-1].all()
        frames = grasps.argmax(axis=0)
        distance = np.linalg.norm(left[frames, np.arange(200)], axis=1)
        ends[blur] = frames.mean(), distance.mean()
    assert ends[0.0][0] < ends[0.005][0] < ends[0.01][0]
    assert ends[0.0][1] < ends[0.005][1] < ends[0.01][1]


def test_the_same_seed_gives_the_same_trial() -> None:
    way = np.array([[0.1, 0.05]])
    one, other = follow(DECLARED, way, 80, seed=3), follow(DECLARED, way, 80, seed=3)
    assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
    assert not np.array_equal(one[0], follow(DECLARED, way, 80, seed=4)[0])
