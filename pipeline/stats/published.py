"""What a published mean and p-value imply: the spread among people, and how many a study would need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from pipeline.stats.power import people_needed, two_sample_power


@dataclass(frozen=True)
class Implied:
    """Of a two-sample t-test of two means with as many people each.

    Attributes:
        t, df: the statistic that the p-value belongs to.
        sd: pooled standard deviation among people, in the measure's unit.
        effect: the difference of the means in those, without correction for few people.
        people: in each sample, for a test of that effect to have the power asked; ``None`` for too many.
    """

    t: float
    df: int
    sd: float
    effect: float
    people: int | None


def implied(first: float, second: float, p: float, people: int, level: float, power: float) -> Implied:
    """What follows from two means, the two-sided p-value and the people in each sample."""
    df = 2 * people - 2
    t = float(np.copysign(stats.t.isf(p / 2, df), first - second))
    sd = (first - second) / t / float(np.sqrt(2 / people))
    effect = (first - second) / sd
    return Implied(t, df, sd, effect, people_needed(two_sample_power, effect, level, power))
