"""What each table of the page should hold, written from the exports beside it, cell by cell."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from pipeline.reporting import numbers
from pipeline.reporting.numbers import (
    centimetres,
    degrees,
    fixed,
    fraction,
    interval,
    metres,
    p_value,
    percent,
    score,
    whole,
)
from tests.stages.report_people_tables import Row, expected_of_people

SYMBOLS = {"theta": "θ", "phi": "φ"}
THINGS = ("tip", "target", "tip_to_target")


def expected(folder: Path) -> dict[str, list[list[str]]]:
    """By the name of each region, the cells of its table."""
    tables = {path.stem: json.loads(path.read_text()) for path in folder.glob("*.json")}
    scenes = list(dict.fromkeys(row["scene"] for row in tables["ranking"]))
    found = {
        "Findings": _rows(tables["claims"], _claim),
        "Findings from zero": _rows(tables["claims_from_zero"], _claim),
        **expected_of_people(tables),
        "Simulated races": _rows(tables["coverage"], _coverage),
        "Trainings": [_trainings(scene, tables["ranking"]) for scene in scenes],
    }
    for scene in scenes:
        own = {name: [row for row in rows if row.get("scene") == scene] for name, rows in tables.items()}
        found[f"Ranking of {scene}"] = _rows(own["ranking"], _ranked)
        found[f"Pairs of {scene}"] = _rows(own["pairs"], _pair)
        found[f"Probes of {scene}"] = _rows(own["world_models"], _probes)
        found[f"World models of {scene}"] = _rows(own["world_models"], _world_model)
        found[f"Learning of {scene}"] = _rows(own["learning"], _learning)
        found[f"Learning of {scene} from zero"] = _rows(own["learning_from_zero"], _learning)
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
    out = "" if row["out_after"] is None else f" out after {row['out_after']} repeats"
    return [
        str(row["rank"]),
        _short(row, "view"),
        f"{degrees(row['theta_deg'])}, {degrees(row['phi_deg'])}",
        row["state"] + out,
        score(row["score_mean"]),
        interval(row["score_low"], row["score_high"]),
        score(row["behind_leader"]),
        interval(row["behind_low"], row["behind_high"]),
        metres(row["return_mean"]),
        interval(row["return_low"], row["return_high"]),
        str(row["repeats"]),
        str(row["failed"]),
    ]


def _pair(row: Row) -> list[str]:
    return [
        f"{_short(row, 'first')} less {_short(row, 'second')}",
        str(row["repeats"]),
        score(row["difference"]),
        interval(row["low"], row["high"]),
    ]


def _learning(row: Row) -> list[str]:
    numbers_m = (metres(row[name]) for name in ("start_m", "end_m", "learned_m"))
    return [_short(row, "view"), *numbers_m, whole(row["frames_to_level"])]


def _probes(row: Row) -> list[str]:
    cells = [_short(row, "view")]
    for what in THINGS:
        kinds = ("probe_linear", "probe_mlp", "guess")
        cells += [centimetres(row[f"{kind}_{what}_m_mean"]) for kind in kinds]
        cells.append(percent(row[f"probe_mlp_{what}_m_mean"] / row[f"guess_{what}_m_mean"]))
    return [*cells, percent(row["target_seen_share_mean"]), percent(row["frames_target_hidden_share_mean"])]


def _world_model(row: Row) -> list[str]:
    facts = ("reconstruction_error_mean", "kl_nats_mean", "active_dimensions_mean")
    foresight = ("heldout_nll_nats_per_latent_mean", "heldout_nll_of_last_frame_nats_per_latent_mean")
    fit, foreseen = (fixed(row[name], 1) for name in facts), (fixed(row[name], 2) for name in foresight)
    return [_short(row, "view"), *fit, *foreseen]


def _coverage(row: Row) -> list[str]:
    return [
        row["population"],
        str(row["views"]),
        row["situation"],
        whole(row["runs"]),
        fraction(row["wrong"]),
        fraction(row["covered"]),
        fixed(row["trainings"], 1),
    ]


def _trainings(scene: str, ranked: Sequence[Row]) -> list[str]:
    own = [row for row in ranked if row["scene"] == scene]
    views = ", ".join(f"{_short(row, 'view')} {row['repeats']}" for row in own)
    return [scene, views, str(sum(row["repeats"] for row in own))]


def _anchors(row: Row) -> list[list[str]]:
    within = percent(row["expert_within_2cm_share_mean"])
    return [
        ["expert (score 1)", metres(row["expert_mean"]), within],
        ["target-blind (score 0)", metres(row["blind_mean"]), "–"],
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
        f"World model: effects of pan θ and tilt φ on the score in {scene}": _rows(
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
    ours = [score(row["difference"]), interval(row["low"], row["high"])]
    told = [row[name] or numbers.MISSING for name in ("direction", "size")]
    outcome = row["outcome"].replace("above blind", "above target-blind")
    return [row["section"], row["scene"], row["judge"], finding, *ours, *told, outcome]
