"""The profile of the closed loop: every second is counted once, and watching changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.loop_profile import PARTS, REST, Clock, TimedControllers, profile, timed_loop
from benchmarks.loops import candidates, setting
from pipeline.control.policy import Controllers
from pipeline.sim.draws import draw_episodes


def test_a_part_within_a_part_is_counted_once() -> None:
    times = iter([0.0, 1.0, 3.0, 7.0, 8.0, 10.0])
    clock = Clock(now_s=lambda: next(times))
    with clock.part("outer"):  # 0 to 10
        for _ in range(2):  # 1 to 3, 7 to 8
            clock.timed("inner", lambda: None)()
    assert clock.seconds == {"outer": 7.0, "inner": 3.0}


def test_watching_changes_no_number() -> None:
    chosen, clock = setting("panda_2dof", 3), Clock()
    episodes = draw_episodes(chosen.scene, 5, np.random.default_rng(1))
    plain = Controllers.of(candidates(chosen.scene, 5), chosen.scene.action_size)
    watched = timed_loop(chosen, clock).run(TimedControllers(plain.weight, plain.bias, clock), episodes)
    np.testing.assert_array_equal(watched.reward, chosen.loop(1).run(plain, episodes).reward)
    assert set(clock.seconds) == set(PARTS)


@pytest.mark.parametrize("scene", ["panda_1dof", "fetch_reach"])
def test_shares_add_up(scene: str) -> None:
    ms, percent = profile(setting(scene, 2))
    for row in (ms, percent):
        assert sum(row[part] for part in PARTS) == pytest.approx(row["all"])
        assert min(row[part] for part in PARTS if part != REST) > 0
