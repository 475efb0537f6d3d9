"""Learning: slopes against least squares, and that it is not mistaken for a difference of views."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.practice import from_block_to_block, over_orders, over_people, slope_within

RNG = np.random.default_rng


def test_the_slope_is_that_of_least_squares_with_a_level_a_block() -> None:
    rng = RNG(1)
    blocks = [(np.arange(1.0, n + 1), np.exp(rng.normal(level, 0.3, n))) for n, level in ((4, 2.0), (3, 0.1))]
    design = np.zeros((7, 3))
    design[:4, 0], design[4:, 1] = 1, 1
    design[:, 2] = np.concatenate([places for places, _ in blocks])
    logs = np.log(np.concatenate([values for _, values in blocks]))
    assert slope_within(blocks) == pytest.approx(np.linalg.lstsq(design, logs)[0][2])


def test_a_steady_change_is_found_exactly() -> None:
    places = np.arange(1.0, 5.0)
    blocks = [(places, 9.0 * 0.97**places), (places, 20.0 * 0.97**places)]
    slope = slope_within(blocks)
    assert slope == pytest.approx(np.log(0.97))
    found = over_people([slope, slope + 1e-3, slope - 1e-3], 0.05)
    assert found.change == pytest.approx(-0.03) and found.people == 3


def test_over_people_is_scipys_t_test_of_one_sample() -> None:
    values = RNG(2).normal(-0.05, 0.1, 9)
    found, scipys = over_people(list(values), 0.05), stats.ttest_1samp(values, 0.0)
    interval = scipys.confidence_interval(0.95)
    assert found.p == pytest.approx(scipys.pvalue)
    assert (found.low, found.high) == pytest.approx((np.expm1(interval.low), np.expm1(interval.high)))


def test_balanced_orders_take_the_views_difference_out() -> None:
    """Whoever has the worse view second seems to get worse, whoever has it first to get better."""
    views, learned, rng = 0.5, -0.1, RNG(3)
    changes = {
        "good first": list(learned + views + rng.normal(0, 0.02, 6)),
        "bad first": list(learned - views + rng.normal(0, 0.02, 4)),
    }
    found = over_orders(changes, 0.05)
    assert found.people == 10
    assert found.low is not None and found.high is not None
    assert found.low < np.expm1(learned) < found.high < np.expm1(learned) + 0.05
    together = over_people([c for own in changes.values() for c in own], 0.05)
    assert together.high is not None and together.high - (together.low or 0) > 5 * (found.high - found.low)


def test_so_few_tell_of_no_spread() -> None:
    assert over_people([], 0.05).change is None and over_people([0.1], 0.05).change is None
    assert over_orders({"a": [0.1], "b": [0.2]}, 0.05).change is None
    assert slope_within([(np.array([1.0]), np.array([2.0]))]) is None
    assert slope_within([(np.array([1.0, 2.0]), np.array([0.0, 1.0]))]) is None  # no logarithm
    assert from_block_to_block(np.array([]), np.array([1.0])) is None
    assert from_block_to_block(np.array([2.0, 2.0]), np.array([1.0, 1.0])) == pytest.approx(-np.log(2))
