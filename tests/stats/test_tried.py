"""Viewpoints tried one at a time, against the intervals of one table."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.blocks import mean_half_width, two_way
from pipeline.stats.tried import Spot, tried


def spot(phi_deg: float, scene: str = "reach") -> Spot:
    return Spot(f"phi-{phi_deg:g}", scene, 45.0, phi_deg)


def test_views_with_equally_many_repeats_share_their_error() -> None:
    values = np.random.default_rng(1).normal(size=(3, 5, 2))
    runs = {spot(10.0 * i): [tuple(pair) for pair in rows] for i, rows in enumerate(values)}
    found = tried(runs, 0.95)
    half = mean_half_width(two_way(values[..., 1]), 0.95)
    for row, rows in zip(found, values, strict=True):
        assert (row.return_mean, row.score_mean) == (pytest.approx(rows[:, 0].mean()), rows[:, 1].mean())
        assert row.score_high - row.score_mean == pytest.approx(half)


def test_a_view_alone_has_students_interval_and_one_repeat_none() -> None:
    scores = [0.2, 0.5, 0.4]
    runs = {spot(0.0): [(-1.0, score) for score in scores], spot(15.0): [(-2.0, 0.1)]}
    several, single = tried(runs, 0.95)
    expected = stats.ttest_1samp(scores, 0).confidence_interval(0.95)
    assert (several.score_low, several.score_high) == pytest.approx((expected.low, expected.high))
    assert (single.repeats, single.score_low, single.score_high) == (1, None, None)


def test_scenes_are_kept_apart_and_the_order_is_kept() -> None:
    near, far = [(-1.0, 0.5), (-1.0, 0.6)], [(-9.0, -0.5), (-3.0, 0.4)]
    runs = {spot(30.0): near, spot(0.0, "desk"): far, spot(10.0): near}
    found = tried(runs, 0.95)
    assert [row.spot for row in found] == list(runs)
    alone = tried({spot(0.0, "desk"): far}, 0.95)[0]
    assert (found[1].score_low, found[1].score_high) == (alone.score_low, alone.score_high)
