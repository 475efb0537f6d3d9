"""What a benchmark gives: rows of the table of goals, and rows of small tables of its own.

A row is a flat dict, one JSON object. A row with a key ``table`` belongs to the small table of that
name, whose columns are the row's other keys; every other row belongs to the table of goals.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Row = dict[str, Any]

NO_CUDA = "no CUDA device"
AT_LEAST, AT_MOST = "at least", "at most"
HEADER = ("work", "scene", "ours", "peer", "unit", "ratio", "goal", "holds")
_WIDTHS = "{:<40} {:<20} {:>9} {:>9} {:<10} {:>7} {:>8} {:<5} {}"
_NOTHING = "–"


def goal_row(
    work: str,
    scene: str,
    ours: float | None,
    peer: float | None,
    unit: str,
    ratio: float | None,
    goal: float | None,
    goal_is: str = AT_LEAST,
    note: str = "",
) -> Row:
    """A row of the table of goals.

    Args:
        work: what is measured.
        scene: where.
        ours: our number; None where it could not be measured.
        peer: the number of what one would run otherwise; None where there is none.
        unit: of both.
        ratio: what is held against the goal; where it is None, ``ours`` is.
        goal: None where none is set.
        goal_is: :data:`AT_LEAST` or :data:`AT_MOST`.
        note: a few words, such as :data:`NO_CUDA`.
    """
    compared = ours if ratio is None else ratio
    holds = None
    if compared is not None and goal is not None:
        holds = bool(compared >= goal if goal_is == AT_LEAST else compared <= goal)
    row = dict(zip(HEADER, (work, scene, ours, peer, unit, ratio, goal, holds), strict=True))
    return {**row, "goal_is": goal_is, "note": note}


def header() -> str:
    """The line above the table of goals."""
    return _WIDTHS.format(*HEADER, "").rstrip()


def line(row: Row) -> str:
    """A line of the table of goals; dashes where there is nothing."""
    sign = "≤" if row.get("goal_is") == AT_MOST else "≥"
    goal = _NOTHING if row["goal"] is None else f"{sign} {number(row['goal'])}"
    holds = {None: _NOTHING, True: "yes", False: "no"}[row["holds"]]
    ours, peer, ratio = (number(row[key]) for key in ("ours", "peer", "ratio"))
    note = row.get("note", "")
    return _WIDTHS.format(
        row["work"], row["scene"], ours, peer, row["unit"], ratio, goal, holds, note
    ).rstrip()


def number(value: float | None) -> str:
    """Three digits, or all of a whole number's."""
    if value is None:
        return _NOTHING
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def side_tables(rows: Sequence[Row]) -> list[str]:
    """The lines of the small tables, each under its name, in the order in which they were first met."""
    lines: list[str] = []
    for name in dict.fromkeys(row["table"] for row in rows):
        members = [{k: v for k, v in row.items() if k != "table"} for row in rows if row["table"] == name]
        lines += ["", f"{name}:", *_table(members)]
    return lines


def _table(rows: Sequence[Row]) -> list[str]:
    columns = list(rows[0])
    cells = [columns, *([_cell(row[column]) for column in columns] for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(columns))]
    words = [isinstance(rows[0][column], str) for column in columns]
    return [
        "  ".join(
            text.ljust(width) if word else text.rjust(width)
            for text, width, word in zip(row, widths, words, strict=True)
        ).rstrip()
        for row in cells
    ]


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else number(value)
