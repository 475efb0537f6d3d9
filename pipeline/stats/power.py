"""How many people the next study needs, by the noncentral t."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import special, stats

MOST_PEOPLE = 10_000


@dataclass(frozen=True)
class NextStudy:
    """People for a paired t-test to find a difference.

    Attributes:
        people: in all, were the true effect the one observed; ``None`` for more than :data:`MOST_PEOPLE`.
        more: beyond those that there are.
        cautious: in all, were it the end of its interval nearer to none; ``None`` where that holds no effect.
        level: of the test, so that the difference also withstands Holm's first step.
    """

    people: int | None
    more: int | None
    cautious: int | None
    level: float


def paired_power(effect: float, people: int, level: float) -> float:
    """Of a two-sided paired t-test; ``effect`` in standard deviations of the differences."""
    return _power(effect * np.sqrt(people), people - 1, level)


def two_sample_power(effect: float, people: int, level: float) -> float:
    """Of a two-sided two-sample t-test with so many people in each sample."""
    return _power(effect * np.sqrt(people / 2), 2 * people - 2, level)


def people_needed(
    power_of: Callable[[float, int, float], float], effect: float, level: float, power: float
) -> int | None:
    """The fewest people with which a test has the power; ``None`` for more than :data:`MOST_PEOPLE`."""
    low, high = 1, 2  # too few, and a guess
    while power_of(effect, high, level) < power:
        low, high = high, 2 * high
        if high > MOST_PEOPLE:
            return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if power_of(effect, middle, level) < power else (low, middle)
    return high


def next_study(effect: float, low: float, high: float, people: int, level: float, power: float) -> NextStudy:
    """What a further study needs.

    Args:
        effect, low, high: d_z observed, with its interval.
        people: observed.
        level: of the next study's test.
        power: that it shall have.
    """
    needed = people_needed(paired_power, effect, level, power)
    nearer = 0.0 if low <= 0 <= high else min(abs(low), abs(high))
    cautious = people_needed(paired_power, nearer, level, power) if nearer else None
    more = None if needed is None else max(0, needed - people)
    return NextStudy(needed, more, cautious, level)


def _power(shift: float, df: float, level: float) -> float:
    least = float(stats.t.isf(level / 2, df))
    within = special.nctdtr(df, abs(shift), np.array([-least, least]))
    below, under = np.nan_to_num(within, nan=0.0)  # SciPy's answer far out in the lower tail
    return float(1 - under + below)
