"""What controllers learned, from curves whose start, end and speed are known."""

from __future__ import annotations

import polars as pl
import pytest

from pipeline.reporting.learning import learned


def _band(means: list[float]) -> pl.DataFrame:
    return pl.DataFrame({"frames": [100.0 * (n + 1) for n in range(len(means))], "mean": means})


FAST = _band([-4.0, -2.0, -1.5, -1.0, -1.0, -1.0, -1.0, -1.0])
SLOW = _band([-5.0, -4.0, -3.5, -3.0, -2.5, -2.5, -2.0, -2.2])


def test_the_level_is_where_the_lowest_view_ends() -> None:
    fast, slow = learned({"a": FAST, "b": SLOW})
    assert (slow.start_m, slow.end_m, slow.learned_m) == pytest.approx((-5.0, -2.1, 2.9))
    assert (fast.level_m, slow.level_m) == pytest.approx((-2.1, -2.1))
    assert (fast.frames_to_level, slow.frames_to_level) == (200, 700)


def test_where_there_was_no_search_nothing_was_learned() -> None:
    assert learned({}) == []
