"""From tables of trials to the statistics of a study, in plain values that hold no person's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import polars as pl

from pipeline.stats.people import Measured, least_people
from pipeline.stats.practice import from_block_to_block, over_orders, over_people, slope_within
from pipeline.study.means import VIEW
from pipeline.study.trials import COUNTS

# Of each measure: its name and unit on the page, its column, and how many units a second or metre has.
MEASURES = (("time", "s", "time_s", 1.0), ("distance error", "cm", "distance_m", 100.0))
PEOPLE, SCRIPTED = "own trials", "scripted operator (synthetic)"  # sources of rows


def summary(trials: pl.DataFrame) -> dict[str, Any] | None:
    """How much there is of own trials, and what was left out for which reason; ``None`` without any."""
    if trials.is_empty():
        return None
    left_out = trials.filter(~COUNTS).explode("reasons")["reasons"].value_counts(sort=True)
    counts = dict(zip(left_out["reasons"].to_list(), left_out["count"].to_list(), strict=True))
    scripted = is_synthetic(trials)
    return {
        "source": SCRIPTED if scripted else PEOPLE,
        "synthetic": scripted,
        "people": trials["participant"].n_unique(),
        "attempts": len(trials),
        "counted": len(trials.filter(COUNTS)),
        "left_out": dict(sorted(counts.items())),
        "least_people": least_people(scripted),
    }


def is_synthetic(trials: pl.DataFrame) -> bool:
    """Whether the trials are the scripted operator's; a study never holds both."""
    return bool((trials["operator"] == "scripted").any())


def measured(means: pl.DataFrame) -> list[Measured]:
    """The people's means under each view, by both measures, view after view."""
    found = []
    for (scene, view, theta, phi), own in means.group_by(*VIEW, maintain_order=True):
        for measure, unit, column, factor in MEASURES:
            pairs = zip(own["participant"].to_list(), (own[column] * factor).to_list(), strict=True)
            angles = (float(str(theta)), float(str(phi)))
            found.append(Measured(str(scene), str(view), angles, measure, unit, dict(pairs)))
    return found


def learning(course: pl.DataFrame, alpha: float, synthetic: bool) -> list[dict[str, Any]]:
    """By scene and measure: the change from trial to trial in a block, and from first block to second."""
    least = least_people(synthetic)
    rows = []
    for (scene,), own in course.group_by("scene", maintain_order=True):
        people = [person for _, person in own.group_by("participant", maintain_order=True)]
        for measure, _, column, _ in MEASURES:
            slopes = [s for p in people if (s := slope_within(list(_blocks(p, column)))) is not None]
            orders = _second_blocks(people, column)
            within = over_people(slopes if len(slopes) >= least else [], alpha)
            # with one order only, the views' difference and what is learned cannot be told apart
            both = len(orders) == 2 and sum(map(len, orders.values())) >= least
            between = over_orders(orders if both else {}, alpha)
            told = {"per_trial": asdict(within), "per_block": asdict(between)}
            rows.append({"scene": scene, "measure": measure, **told})
    return rows


def course_of_all(course: pl.DataFrame, synthetic: bool) -> list[dict[str, Any]]:
    """By trial of the session: the people's geometric mean, relative to their own under the same view."""
    columns = {"time": "relative_time", "distance": "relative_distance"}
    grouped = course.group_by("trial").agg(
        pl.len().alias("people"),
        *(pl.col(column).log().mean().exp().alias(name) for name, column in columns.items()),
    )
    return grouped.filter(pl.col("people") >= least_people(synthetic)).sort("trial").to_dicts()


def _blocks(person: pl.DataFrame, column: str) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for _, block in person.group_by("turn", maintain_order=True):
        yield block["place"].to_numpy(), block[column].to_numpy()


def _second_blocks(people: Sequence[pl.DataFrame], column: str) -> dict[str, list[float]]:
    """Of each person the change from first block to second, by the view that came first."""
    found: dict[str, list[float]] = {}
    for person in people:
        turns = [person.filter(pl.col("turn") == n) for n in (1, 2)]
        change = from_block_to_block(*(turn[column].to_numpy() for turn in turns))
        if change is not None:
            found.setdefault(str(turns[0]["view"][0]), []).append(change)
    return found
