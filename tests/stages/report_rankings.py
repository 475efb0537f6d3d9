"""Made-up rankings, as the stage `ranking` leaves them, for tests of the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy import stats

REPOSITORY = Path(__file__).parents[2]
PROVENANCE = {"device": "cpu", "dtype": "bfloat16", "threads": 2, "torch": "2.13.0", "mujoco": "3.17.0"}
NO_OP, BLIND, EXPERT = -10.83, -6.59, -2.37  # returns, m
UNIT, TOLERANCE, FIRST, MOST = EXPERT - BLIND, 0.05, 3, 20
CHEAP = ("projected motion, weakest direction (px/m)", "linear probe of tip - target (m)")

Angles = Mapping[str, tuple[float, float]]


def ranking(
    scene: str,
    views: Angles,
    returns: Mapping[str, Sequence[float]],
    *,
    opened: bool = False,
    networks: int = 0,
) -> dict[str, Any]:
    """A scene's ranking: the best leads, the next may be as good, the others are out or cannot see.

    Args:
        scene: its name.
        views: θ and φ by branch.
        returns: of each branch's repeats (m); from the fifth place on a judge cannot see.
        opened: the race is not over.
        networks: how many deep Q-networks judge each view.
    """
    order = sorted(views, key=lambda key: -float(np.mean(returns[key])))
    means = {key: (float(np.mean(returns[key])) - BLIND) / UNIT for key in order}
    blind = order[4:]
    racing = [key for key in order if key not in blind]
    keys = racing[:2]
    rows = {
        key: _row(place, key, order, views[key], returns[key], means, key in blind)
        for place, key in enumerate(order, start=1)
    }
    within = 0.01 + 0.006 * len(views)
    kind = "open" if opened else "tolerance"
    return {
        "scene": scene,
        "confidence": 0.95,
        "tolerance": TOLERANCE,
        "unit_m": UNIT,
        "blind_m": BLIND,
        "first": FIRST,
        "most": MOST,
        "answer": _answer(scene, kind, keys, views, within),
        "race": _race(keys, racing, within, opened),
        "anchors": {"no_op": NO_OP, "blind": BLIND, "expert": EXPERT},
        "viewpoints": rows,
        "pairs": [_pair(a, b, returns) for a, b in combinations(racing, 2)],
        "spread": {"sd": 0.0312, "df": 7},
        **judges(scene, views, networks),
        "claims": claims(scene, networks),
        "baselines": [_baseline(place, name, order) for place, name in enumerate(CHEAP)],
        "provenance": PROVENANCE,
    }


def _row(
    place: int,
    key: str,
    order: Sequence[str],
    angles: tuple[float, float],
    returns: Sequence[float],
    means: Mapping[str, float],
    blind: bool,
) -> dict[str, Any]:
    half, wide = _half(returns), 0.04 + 0.004 * len(order)
    behind = None if place == 1 or blind else means[order[0]] - means[key]
    state = ["leader", "may be as good", "not the best"][min(place, 3) - 1]
    return {
        "rank": place,
        "theta_deg": float(angles[0]),
        "phi_deg": float(angles[1]),
        "repeats": len(returns),
        **_around("return", float(np.mean(returns)), half),
        **_around("score", means[key], None if half is None else half / UNIT),
        "behind_leader": behind,
        "behind_low": None if behind is None else behind - wide,
        "behind_high": None if behind is None else behind + wide,
        "state": "cannot see" if blind else state,
        "out_after": FIRST if state == "not the best" and not blind else None,
        "failed": int(place == 3),
        "misses": ["tip", "target"] if blind else [],
        "probe_m": 0.113 if blind else 0.031,
        "guess_m": 0.187,
        "duplicates": [],
    }


def _half(values: Sequence[float]) -> float | None:
    if len(values) == 1:
        return None
    return float(stats.t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / len(values) ** 0.5)


def _around(name: str, value: float, half: float | None) -> dict[str, float | None]:
    low, high = (None, None) if half is None else (value - half, value + half)
    return {f"{name}_mean": value, f"{name}_low": low, f"{name}_high": high}


def _answer(scene: str, kind: str, keys: Sequence[str], views: Angles, within: float) -> dict[str, Any]:
    theta, phi = views[keys[0]]
    leader, *others = (key.removeprefix(f"{scene}-") for key in keys)
    best = f"{leader} is the best view or within {within:.2f} of the best"
    also = f" {' and '.join(others)} may be as good." if others else ""
    return {
        "kind": kind,
        "keys": list(keys),
        "within": within,
        "sure": True,
        "forecast_trainings": 14 if kind == "open" else None,
        "sentence": f"Put the camera at ({theta:g}°, {phi:g}°): {best} (95 % sure).{also}",
        "progress": f"{scene}, repeat 5 of at most {MOST}: {leader} leads. Best or within {within:.2f}.",
    }


def _race(keys: Sequence[str], racing: Sequence[str], within: float, opened: bool) -> dict[str, Any]:
    looks = [
        {"repeats": n, "leader": keys[0], "within": within + 0.04 * (5 - n), "active": list(racing)}
        for n in range(FIRST, 6)
    ]
    return {
        "open": opened,
        "common": 5,
        "active": list(keys),
        "out": dict.fromkeys(racing[2:], FIRST),
        "leader": keys[0],
        "lead_low": -within,
        "lead_high": 0.127,
        "looks": looks,
    }


def _pair(first: str, second: str, returns: Mapping[str, Sequence[float]]) -> dict[str, Any]:
    common = min(len(returns[first]), len(returns[second]))
    gap = float(np.mean(returns[first][:common]) - np.mean(returns[second][:common])) / UNIT
    low, high = (None, None) if common == 1 else (gap - 0.08, gap + 0.08)
    return {"first": first, "second": second, "repeats": common, "difference": gap, "low": low, "high": high}


def _baseline(place: int, name: str, order: Sequence[str]) -> dict[str, Any]:
    values = {key: 0.1 + 0.0371 * (n * 7 % 5) for n, key in enumerate(order)}
    more = (
        {"tau": 0.2, "p": 0.714, "same_sign": None}
        if len(order) > 2
        else {"tau": 1.0, "p": None, "same_sign": True}
    )
    return {"name": name, "stage": ("geometry", "vae")[place], "values": values, **more}


def judges(scene: str, views: Angles, networks: int) -> dict[str, Any]:
    """The parts on judges: a grid's effects, and the networks' where there are any."""
    if scene != "fetch_reach":
        return {"factorial": None, "dqn": None, "judges": None}
    ours, theirs = _factorial(0.13, "differs"), _factorial(0.012, "not settled")
    if not networks:
        return {"factorial": ours, "dqn": None, "judges": None}
    rows = {
        key: {
            "return_mean": -4.41 - n / 9,
            "score_mean": 0.44 - n / 50,
            "score_of_restricted_mean": 0.5 - n / 50,
        }
        for n, key in enumerate(views)
        if key != "study"
    }
    dqn = {
        "repeats": networks,
        "viewpoints": rows,
        "score_half_width": 0.061,
        "restricted_expert_return": -2.6,
        "factorial": theirs,
    }
    steps = [{**step, "p": 0.0412} for step in ours["effects"]]
    both = {"test": {"df": 5, "df_error": 17.3, "f": 3.21, "p": 0.0319}, "effects": steps}
    return {"factorial": ours, "dqn": dqn, "judges": both}


def _factorial(gap: float, word: str) -> dict[str, Any]:
    steps = [("theta", 0.0, 45.0), ("theta", 0.0, 90.0), ("theta", 45.0, 90.0), ("phi", 30.0, 45.0)]
    effects = [
        {"factor": factor, "first_deg": first, "second_deg": second, "difference": gap + n / 70,
         "low": gap + n / 70 - 0.1, "high": gap + n / 70 + 0.1, "equivalence_low": gap + n / 70 - 0.07,
         "equivalence_high": gap + n / 70 + 0.07, "se": 0.04, "word": word}
        for n, (factor, first, second) in enumerate(steps)
    ]  # fmt: skip
    tests = {
        name: {"df": 2, "df_error": 10, "f": 4.321, "p": 0.044} for name in ("theta", "phi", "interaction")
    }
    return {"df_error": 10, "margin": 0.1, "tests": tests, "effects": effects}


OUTCOMES = [
    {"direction": "same", "size": "may matter", "outcome": "agrees"},
    {"direction": "opposite", "size": "may matter", "outcome": "contradicts"},
    {"direction": "not settled, leans the same way", "size": "below 0.1", "outcome": "not settled"},
    {"direction": "not settled, leans the other way", "size": "may matter", "outcome": "not settled"},
    {"direction": None, "size": None, "outcome": "cannot see"},
]
NOT_RUN = {"direction": None, "size": None, "outcome": "not run"}


def claims(scene: str, networks: int) -> list[dict[str, Any]]:
    """The scene's claims with made-up outcomes."""
    asked = yaml.safe_load((REPOSITORY / "data/reference/claims.yaml").read_text(encoding="utf-8"))
    found = []
    for n, claim in enumerate(claim for claim in asked if claim["scene"] == scene):
        ran = networks or claim["judge"] == "world model"
        outcome = OUTCOMES[n % len(OUTCOMES)] if ran else NOT_RUN
        told = ran and claim["finding"] == "higher" and outcome["direction"]
        numbers = (0.0831, -0.021, 0.187) if told else (None, None, None)
        shown = dict(zip(("difference", "low", "high"), numbers, strict=True))
        if claim["finding"] == "none":  # it has no direction
            outcome = {**outcome, "direction": None}
        found.append({"first_deg": None, "second_deg": None, **claim, **shown, **outcome})
    return found
