"""How rows are compared with their goals and laid out."""

from __future__ import annotations

import pytest

from benchmarks.rows import AT_MOST, goal_row, header, line, number, side_tables


@pytest.mark.parametrize(
    ("ours", "ratio", "goal", "holds"),
    [(1.0, 6.0, 6.0, True), (9.0, 5.9, 6.0, False), (9.0, 5.9, None, None), (None, None, 6.0, None)],
)
def test_a_ratio_is_held_against_its_goal(
    ours: float | None, ratio: float | None, goal: float | None, holds: bool | None
) -> None:
    assert goal_row("w", "s", ours, 1.0, "u", ratio, goal)["holds"] is holds


@pytest.mark.parametrize(("seconds", "holds"), [(79.9, True), (80.1, False)])
def test_without_a_ratio_our_own_number_is(seconds: float, holds: bool) -> None:
    assert goal_row("w", "s", seconds, None, "s", None, 80.0, AT_MOST)["holds"] is holds


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (12345.6, "12346"), (99.94, "99.9"), (0.0123, "0.0123"), (8, "8"), (0, "0")],
)
def test_numbers_keep_three_digits(value: float | None, text: str) -> None:
    assert number(value) == text


def test_columns_of_the_goals_stand_below_each_other() -> None:
    row = line(goal_row("closed loop against plain, as it comes", "panda_2dof", 2000, 9, "frames/s", 222, 30))
    top = header()
    for name, text in (("scene", "panda_2dof"), ("unit", "frames/s"), ("holds", "yes")):
        assert top.index(name) == row.index(text)


def test_each_small_table_has_its_own_columns() -> None:
    rows = [
        {"table": "a", "scene": "long name", "ms": 0.5},
        {"table": "b", "worlds": 8, "frames/s": 1234.5},
        {"table": "a", "scene": "short", "ms": None},
    ]
    assert side_tables(rows) == [
        *("", "a:", "scene       ms", "long name  0.5", "short        –"),
        *("", "b:", "worlds  frames/s", "     8      1234"),
    ]
