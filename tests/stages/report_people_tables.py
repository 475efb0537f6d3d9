"""What the tables on people should hold, written from the exports beside the page, cell by cell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pipeline.reporting.numbers import (
    MISSING,
    degrees,
    fixed,
    fraction,
    interval,
    p_value,
    percent,
    score,
    whole,
)

Row = Mapping[str, Any]
LABELS = {"time": "Task time", "distance error": "Distance error"}
KINDS = {"two_sample": "two-sample t", "paired": "paired t", "signed_ranks": "Wilcoxon"}


def expected_of_people(tables: Mapping[str, Sequence[Row]]) -> dict[str, list[list[str]]]:
    """By the name of each region, the cells of its table; own trials' tables where there are some."""
    found = {
        "Means of people": list(_means(tables["people"])),
        "People and world model": [_person(row) for row in tables["people"]],
        "Implied by Table 2": [_implied(row) for row in tables["people_implied"]],
        "Scripted operator": [_operator(row, tables["ranking"]) for row in tables["operator"]],
    }
    if "people_tests" in tables:
        found["Tests of own trials"] = [_test(row, kind) for row in tables["people_tests"] for kind in KINDS]
        found["Next study"] = [_next(row) for row in tables["people_tests"]]
        found["Learning of people"] = [_learning(row) for row in tables["people_learning"]]
    return found


def _views(row: Row) -> list[str]:
    return [f"({degrees(row[f'{one}_theta'])}, {degrees(row[f'{one}_phi'])})" for one in ("first", "second")]


def _means(rows: Sequence[Row]) -> Iterator[list[str]]:
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    for source in dict.fromkeys(row["source"] for row in rows):
        own = {(r["scene"], r["measure"]): r for r in rows if r["source"] == source}
        people = next(iter(own.values()))["people"]
        yield [f"{source}, {people} {'people' if source == 'Liu et al.' else 'participants'}"]
        for measure in LABELS:
            cells = [own.get((scene, measure)) for scene in scenes]
            unit = next(row["unit"] for row in cells if row)
            pairs = [(row["first"], row["second"]) if row else (None, None) for row in cells]
            yield [f"{LABELS[measure]} ({unit})", *(fixed(v, 2) for pair in pairs for v in pair)]
        for measure in LABELS:
            ps = [own[scene, measure]["p"] if (scene, measure) in own else None for scene in scenes]
            yield [f"p of {LABELS[measure].lower()}", *map(p_value, ps)]


def _test(row: Row, kind: str) -> list[str]:
    people = (
        f"{row['people_first']} and {row['people_second']}" if kind == "two_sample" else str(row["pairs"])
    )
    first, second = _views(row)
    named = [row["scene"], f"{row['measure']}, {row['unit']}", f"{first} less {second}", KINDS[kind], people]
    own = {name.removeprefix(f"{kind}_"): v for name, v in row.items() if name.startswith(f"{kind}_")}
    if own["p"] is None:
        return [*named, *[MISSING] * 7]
    ranks = kind == "signed_ranks"
    symbol = {"two_sample": "g", "paired": "d", "signed_ranks": "r"}[kind]
    return [
        *named,
        fixed(own["shift" if ranks else "difference"], 2),
        interval(own["low"], own["high"]),
        f"W = {own['w']:g}" if ranks else f"t({own['df']:.0f}) = {fixed(own['t'], 2)}",
        p_value(own["p"]),
        p_value(own["holm"]),
        f"{symbol} = {fixed(own['effect'], 2)}",
        MISSING if ranks else interval(own["effect_low"], own["effect_high"]),
    ]


def _next(row: Row) -> list[str]:
    more = row["next_more"]
    words = {0: "enough", 1: "1 more person"}.get(more, f"{whole(more)} more people")
    if row["next_level"] is None:
        words = MISSING
    elif more is None:
        words = "more than 10,000"
    needed = [whole(row[name]) for name in ("next_people", "next_cautious")]
    named = [row["scene"], row["measure"], str(row["pairs"]), fixed(row["paired_effect"], 2)]
    return [*named, needed[0], words, needed[1]]


def _learning(row: Row) -> list[str]:
    cells = [row["scene"], row["measure"]]
    for part in ("trial", "block"):
        low, high = (fraction(row[f"{part}_{end}"]) for end in ("low", "high"))
        cells += [fraction(row[f"{part}_change"]), f"{low} to {high}", p_value(row[f"{part}_p"])]
    return cells


def _implied(row: Row) -> list[str]:
    return [
        row["scene"],
        f"{row['measure']}, {row['unit']}",
        f"t({row['df']}) = {fixed(row['t'], 2)}",
        fixed(row["sd"], 2),
        fixed(row["effect"], 2),
        whole(row["people"]),
    ]


def _operator(row: Row, ranking: Sequence[Row]) -> list[str]:
    (view,) = [r for r in ranking if (r["scene"], r["view"]) == (row["scene"], row["view"])]
    looks = {axis: row[f"look_{axis}_m"] for axis in "xyz"}
    return [
        row["scene"],
        row["view"].removeprefix(f"{row['scene']}-"),
        f"{degrees(view['theta_deg'])}, {degrees(view['phi_deg'])}",
        str(row["trials"]),
        percent(row["grasped_share"]),
        fixed(row["time_s_mean"], 1),
        fixed(100 * row["distance_m_mean"], 2),
        ", ".join(f"{axis} {fixed(1000 * v, 1)}" for axis, v in looks.items() if v is not None),
    ]


def _person(row: Row) -> list[str]:
    return [
        row["source"],
        row["scene"],
        " and ".join(_views(row)),
        f"{row['measure']}, {row['unit']}",
        fixed(row["first"], 2),
        fixed(row["second"], 2),
        percent(row["people_advantage"]),
        p_value(row["p"]),
        p_value(row["p_holm"]),
        score(row["ours"]),
        interval(row["low"], row["high"]),
        _preferred(row),
    ]


def _preferred(row: Row) -> str:
    if row["same_sign"] is None:
        return MISSING
    return ("" if row["settled"] else "leans ") + ("yes" if row["same_sign"] else "no")
