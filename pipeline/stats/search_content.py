"""A search as plain tables, for JSON and CSV, and in words."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from pipeline.stats.answer import Answer, answer, race_part
from pipeline.stats.blocks import own_interval
from pipeline.stats.messages import progress, sentence
from pipeline.stats.ranks import rank
from pipeline.stats.searched import Search, Searched

FINALIST, DROPPED, UNSEEING, WAITING = "finalist", "dropped", "cannot see", "in the search"
NOUN = "finalist"


def found_answer(scene: str, searched: Searched, search: Search, confidence: float) -> Answer | None:
    """The answer among the finalists; ``None`` before their race has had a look."""
    if search.race is None:
        if search.keys:
            return None
        unseeing = rank(searched.results(list(searched.views)), None, confidence)
        return answer(scene, None, unseeing, confidence, [])
    results = searched.results(search.finalists, search.spent)
    rows = rank(results, search.race, confidence)
    scores = [results.scores[key] for key in search.finalists]
    return answer(scene, search.race, rows, confidence, scores, NOUN)


def answer_part(found: Answer | None) -> dict[str, Any] | None:
    """The answer, in numbers and in words."""
    if found is None:
        return None
    parts = {"kind": found.kind, "keys": found.keys, "within": found.within, "sure": found.sure}
    return {**parts, "forecast_trainings": found.forecast, "sentence": sentence(found)}


def progress_line(scene: str, searched: Searched, search: Search, found: Answer | None) -> str:
    """How far the search is."""
    made = sum(map(len, searched.returns.values()))
    if found is not None and search.race is not None:
        return f"{progress(found)} {made} trainings so far."
    if not search.keys:
        return f"{scene}: this judge sees the task from none of {len(searched.views)} candidates."
    halving = search.halving
    return (
        f"{scene}: {len(halving.active)} of {len(searched.views)} candidates left after "
        f"{len(halving.rounds)} round(s) of halving; {made} trainings so far."
    )


def search_parts(searched: Searched, search: Search, confidence: float) -> dict[str, Any]:
    """Where the search stands: what it needs, its rounds, the finalists' race and every candidate."""
    names = search.keys
    rounds = [
        {
            "repeats": one.repeats,
            "entered": [names[view] for view in one.entered],
            "kept": [names[view] for view in one.kept],
        }
        for one in search.halving.rounds
    ]
    return {
        "open": bool(search.needed),
        "needed": search.needed,
        "trainings": sum(map(len, searched.returns.values())),
        "rounds": rounds,
        "finalists": search.finalists,
        "race": race_part(search.race, search.finalists),
        "candidates": {key: _candidate(key, searched, search, confidence) for key in searched.views},
    }


def finalist_rows(searched: Searched, search: Search, confidence: float) -> list[dict[str, Any]]:
    """The finalists' table on fresh repeats, best first; none before their race."""
    if search.race is None:
        return []
    return [
        asdict(row) for row in rank(searched.results(search.finalists, search.spent), search.race, confidence)
    ]


def table(scene: str, parts: dict[str, Any]) -> list[dict[str, Any]]:
    """One line per candidate, for CSV."""
    return [{"scene": scene, "candidate": key, **row} for key, row in parts["candidates"].items()]


def scores_by_training(searched: Searched) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Of every training its candidate, its repeat and its score."""
    tried = list(searched.returns)
    scores = searched.results(tried).scores
    keys = [key for key in tried for _ in scores[key]]
    repeats = [number for key in tried for number in range(len(scores[key]))]
    return keys, np.array(repeats), np.concatenate([*scores.values(), np.empty(0)])


def _candidate(key: str, searched: Searched, search: Search, confidence: float) -> dict[str, Any]:
    view, sight = searched.views[key], searched.sight.get(key)
    scores = searched.results([key]).scores[key]
    mean, low, high = own_interval(scores, confidence) if len(scores) else (None, None, None)
    return {
        "theta_deg": view.theta,
        "phi_deg": view.phi,
        "distance_m": view.distance_m,
        "fov_deg": view.fov_deg,
        "repeats": len(scores),
        "score_mean": mean,
        "score_low": low,
        "score_high": high,
        "state": _state(key, searched, search),
        "dropped_after": _dropped_after(key, search),
        "misses": " and ".join(sight.misses) if sight else "",
    }


def _state(key: str, searched: Searched, search: Search) -> str:
    if key not in search.keys:
        return UNSEEING
    if key in search.finalists:
        return FINALIST
    return WAITING if search.keys.index(key) in search.halving.active else DROPPED


def _dropped_after(key: str, search: Search) -> int | None:
    if key not in search.keys:
        return None
    view = search.keys.index(key)
    return next((r.repeats for r in search.halving.rounds if view in r.entered and view not in r.kept), None)
