"""What each table of the page should hold, written from the twins beside it, cell by cell."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.reporting import numbers
from pipeline.reporting.numbers import (
    centimetres,
    chance,
    degrees,
    fixed,
    interval,
    metres,
    p_value,
    percent,
    score,
)

Row = Mapping[str, Any]
SYMBOLS = {"theta": "θ", "phi": "φ"}
PROBES = [
    f"probe_{kind}_{what}_m_mean" for kind in ("linear", "mlp") for what in ("tip", "target", "tip_to_target")
]


def expected(folder: Path) -> dict[str, list[list[str]]]:
    """By the name of each region, the cells of its table."""
    tables = {path.stem: json.loads(path.read_text()) for path in folder.glob("*.json")}
    scenes = list(dict.fromkeys(row["scene"] for row in tables["ranking"]))
    found = {
        "Findings": _rows(tables["claims"], _claim),
        "People and world model": _rows(tables["people"], _person),
    }
    for scene in scenes:
        own = {name: [row for row in rows if row.get("scene") == scene] for name, rows in tables.items()}
        found[f"Ranking of {scene}"] = _rows(own["ranking"], _ranked)
        found[f"Pairs of {scene}"] = _rows(own["pairs"], _pair)
        found[f"World models of {scene}"] = _rows(own["world_models"], _world_model)
        found[f"Anchors of {scene}"] = _anchors(own["anchors"][0])
        found[f"Baselines of {scene}"] = _baselines(own["baselines"], [row["view"] for row in own["ranking"]])
        if own.get("dqn"):
            found |= _judges(scene, own)
    return found


def _rows(rows: Sequence[Row], cells: Callable[[Row], list[str]]) -> list[list[str]]:
    return [cells(row) for row in rows]


def _short(row: Row, name: str) -> str:
    return str(row[name]).removeprefix(f"{row['scene']}-")


def _ranked(row: Row) -> list[str]:
    return [
        str(row["rank"]),
        _short(row, "view"),
        f"{degrees(row['theta_deg'])}, {degrees(row['phi_deg'])}",
        str(row["repeats"]),
        score(row["score_mean"]),
        interval(row["score_low"], row["score_high"]),
        metres(row["return_mean"]),
        interval(row["return_low"], row["return_high"]),
        metres(row["difference_to_best"]),
        interval(row["difference_low"], row["difference_high"]),
        chance(row["best_chance"]),
        row["verdict"],
    ]


def _pair(row: Row) -> list[str]:
    return [
        f"{_short(row, 'first')} less {_short(row, 'second')}",
        metres(row["difference"]),
        interval(row["low"], row["high"]),
        fixed(row["hedges_g"], 1),
        p_value(row["welch_p"]),
        "over 1000" if row["repeats_needed"] is None else str(row["repeats_needed"]),
    ]


def _world_model(row: Row) -> list[str]:
    seen = ("target_seen_share_mean", "frames_target_hidden_share_mean")
    facts = ("reconstruction_error_mean", "kl_nats_mean", "active_dimensions_mean")
    foresight = ("heldout_nll_mean", "heldout_nll_of_last_frame_mean")
    return [
        _short(row, "view"),
        *(centimetres(row[name]) for name in PROBES),
        *(percent(row[name]) for name in seen),
        *(fixed(row[name], 1) for name in (*facts, *foresight)),
    ]


def _anchors(row: Row) -> list[list[str]]:
    within = percent(row["expert_within_2cm_share_mean"])
    return [
        ["expert (score 1)", metres(row["expert_mean"]), within],
        ["blind (score 0)", metres(row["blind_mean"]), "–"],
        ["no-op", metres(row["no_op_mean"]), "–"],
    ]


def _baselines(rows: Sequence[Row], views: Sequence[str]) -> list[list[str]]:
    """All but the last column, the seconds, which come from no table."""
    found = []
    for name in dict.fromkeys(row["baseline"] for row in rows):
        own = {row["view"]: row for row in rows if row["baseline"] == name}
        first = own[views[0]]
        cells = [name, *(f"{own[view]['value']:.3g}" for view in views)]
        if len(views) > 2:
            cells += [fixed(first["tau"], 2), "–" if first["p"] is None else p_value(first["p"])]
        else:
            cells += [{None: "alike", True: "yes", False: "no"}[first["same_sign"]]]
        found.append(cells)
    return found


def _judges(scene: str, own: Mapping[str, Sequence[Row]]) -> dict[str, list[list[str]]]:
    judges = ("world model", "dqn", "world model over dqn")
    effects = {judge: [row for row in own["effects"] if row["judge"] == judge] for judge in judges}
    ranked = {row["view"]: row for row in own["ranking"]}
    both = [
        [
            _short(row, "view"),
            f"{degrees(ranked[row['view']]['theta_deg'])}, {degrees(ranked[row['view']]['phi_deg'])}",
            metres(ranked[row["view"]]["return_mean"]),
            score(ranked[row["view"]]["score_mean"]),
            metres(row["return_mean"]),
            score(row["score_mean"]),
            score(row["score_of_restricted_mean"]),
        ]
        for row in sorted(own["dqn"], key=lambda row: ranked[row["view"]]["rank"])
    ]
    return {
        f"World model: effects of pan θ and tilt φ on the normalised score in {scene}": _rows(
            effects["world model"], _effect
        ),
        "DQN: the same effects": _rows(effects["dqn"], _effect),
        f"Both judges in {scene}": both,
        f"Judge by view in {scene}": [
            [*_step(row), p_value(row["p_holm"])] for row in effects["world model over dqn"]
        ],
    }


def _step(row: Row) -> list[str]:
    step = f"{SYMBOLS[row['factor']]}: {degrees(row['first_deg'])} less {degrees(row['second_deg'])}"
    return [step, score(row["difference"]), interval(row["low"], row["high"])]


def _effect(row: Row) -> list[str]:
    return [*_step(row), interval(row["equivalence_low"], row["equivalence_high"]), row["word"]]


def _claim(row: Row) -> list[str]:
    symbol = SYMBOLS[row["factor"]]
    finding = f"{symbol} makes no difference"
    if row["finding"] == "higher":
        finding = (
            f"{symbol} = {degrees(row['first_deg'])} gives more than {symbol} = {degrees(row['second_deg'])}"
        )
    ours = [score(row["difference"]), interval(row["low"], row["high"]), row["outcome"]]
    return [row["section"], row["scene"], row["judge"], finding, *ours]


def _person(row: Row) -> list[str]:
    views = [f"({degrees(row[f'{one}_theta'])}, {degrees(row[f'{one}_phi'])})" for one in ("first", "second")]
    return [
        row["scene"],
        " and ".join(views),
        f"{row['measure']}, {row['unit']}",
        fixed(row["first"], 2),
        fixed(row["second"], 2),
        percent(row["people_advantage"]),
        p_value(row["p"]),
        p_value(row["p_holm"]),
        metres(row["ours"]),
        interval(row["low"], row["high"]),
        {None: numbers.MISSING, True: "yes", False: "no"}[row["same_sign"]],
    ]
