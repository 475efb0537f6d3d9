"""All pairs of the views in a race, each over its common repeats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from pipeline.stats.replay import Race


@dataclass(frozen=True)
class Pair:
    """One view less another, in score.

    Attributes:
        first, second: the views' names.
        repeats: that both have, of those that the race looked at.
        difference, low, high: with the t interval of this pair alone: not simultaneous, and it takes no
            account of how often the race looked.
    """

    first: str
    second: str
    repeats: int
    difference: float
    low: float
    high: float


def pairs(keys: Sequence[str], race: Race | None, confidence: float) -> list[Pair]:
    """All pairs of the race's views; ``keys`` are their names."""
    if race is None:
        return []
    found = []
    for first, second in combinations(range(len(keys)), 2):
        gap = race.between(first, second, confidence)
        found.append(Pair(keys[first], keys[second], gap.repeats, gap.difference, gap.low, gap.high))
    return found
