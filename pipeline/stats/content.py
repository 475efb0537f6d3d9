"""A scene's ranking as plain tables, for JSON and CSV."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from pipeline.stats.answer import Answer, race_part
from pipeline.stats.branches import Results
from pipeline.stats.messages import progress, sentence
from pipeline.stats.pairs import pairs
from pipeline.stats.params import RankingParams
from pipeline.stats.race import Rules
from pipeline.stats.ranks import Ranked
from pipeline.stats.replay import Race


def race_parts(results: Results, race: Race | None, rows: list[Ranked], confidence: float) -> dict[str, Any]:
    """The race, the anchors, each view's line, each pair in the race, and how far repeats scatter."""
    return {
        "race": race_part(race, results.seen),
        "anchors": {name: float(values.mean()) for name, values in results.anchors.items()},
        "viewpoints": {row.key: {k: v for k, v in asdict(row).items() if k != "key"} for row in rows},
        "pairs": [asdict(pair) for pair in pairs(results.seen, race, confidence)],
        "spread": _spread(race),
    }


def head(results: Results, rules: Rules, method: RankingParams) -> dict[str, Any]:
    """What the scene was asked, and in which unit it answers."""
    return {
        "confidence": method.confidence,
        "tolerance": method.tolerance,
        "unit_m": results.unit_m,
        "blind_m": results.blind_m,
        "first": rules.first,
        "most": rules.most,
    }


def answer_part(found: Answer) -> dict[str, Any]:
    """The answer, in numbers and in words."""
    return {
        "kind": found.kind,
        "keys": found.keys,
        "within": found.within,
        "sure": found.sure,
        "forecast_trainings": found.forecast,
        "sentence": sentence(found),
        "progress": progress(found),
    }


def table(scene: str, rows: list[Ranked]) -> list[dict[str, Any]]:
    """One line per view, for CSV."""
    lines = []
    for row in rows:
        line = asdict(row)
        said = {"misses": " and ".join(line.pop("misses")), "duplicates": " ".join(line.pop("duplicates"))}
        named = {"scene": scene, "rank": line.pop("rank"), "branch": line.pop("key")}
        lines.append({**named, **line, **said})
    return lines


def _spread(race: Race | None) -> dict[str, float | None]:
    """One repeat's, in score; no key may be "error", which DVC takes for a metric that failed to load."""
    if race is None or not race.last.error.df:
        return {"sd": None, "df": None}
    return {"sd": float(race.last.error.variance) ** 0.5, "df": float(race.last.error.df)}


def joined(provenance: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """What the branches were made with; values that differ stand side by side."""
    names = sorted({name for made in provenance.values() for name in made})
    return {name: " | ".join(sorted({str(made.get(name)) for made in provenance.values()})) for name in names}
