"""Do people get better in the course of a session? Changes of the logarithm, by person, then over people.

Where the order of views is balanced, learning favours none of them; where it is large it costs power, and
more practice is due.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats


@dataclass(frozen=True)
class Change:
    """A relative change, -0.03 for 3 % less, over people.

    Attributes:
        people: who contributed.
        change, low, high: their geometric mean and its t interval; ``None`` where so few tell of no spread.
        p: of no change, two-sided.
    """

    people: int
    change: float | None
    low: float | None
    high: float | None
    p: float | None


def slope_within(blocks: Sequence[tuple[np.ndarray, np.ndarray]]) -> float | None:
    """A person's change of the logarithm from one trial to the next, blocks apart from one another.

    Args:
        blocks: of each its trials' places (n,) and values (n,).

    Returns:
        The common slope; ``None`` where no block has two trials or a value is not above zero.
    """
    top = bottom = 0.0
    for places, values in blocks:
        if len(values) < 2 or np.min(values) <= 0:
            continue
        away = places - np.mean(places)
        top += float(away @ np.log(values))
        bottom += float(away @ away)
    return top / bottom if bottom else None


def from_block_to_block(first: np.ndarray, second: np.ndarray) -> float | None:
    """A person's change of the mean logarithm from a task's first block to its second.

    It holds the views' difference, too, which :func:`over_orders` takes out.
    """
    if not len(first) or not len(second) or min(np.min(first), np.min(second)) <= 0:
        return None
    return float(np.log(second).mean() - np.log(first).mean())


def over_people(changes: Sequence[float], alpha: float) -> Change:
    """The mean change of the logarithm, told as a relative change."""
    return over_orders({"": changes}, alpha)


def over_orders(changes: Mapping[str, Sequence[float]], alpha: float) -> Change:
    """The mean change over people who had the views in different orders, each order weighing the same.

    Args:
        changes: of the logarithm, by what came first; people of an order share the views' difference, so the
            spread among people is that within orders, and half of one order and half of the other hold none
            of it.
        alpha: of the interval.
    """
    groups = [np.asarray(own, dtype=float) for own in changes.values() if len(own)]
    n = sum(map(len, groups))
    df = n - len(groups)
    squares = sum(float(((own - own.mean()) ** 2).sum()) for own in groups)
    if df < 1 or not squares > 0:
        return Change(n, None, None, None, None)
    mean = float(np.mean([own.mean() for own in groups]))
    se = float(np.sqrt(squares / df * sum(1 / len(own) for own in groups))) / len(groups)
    half = float(stats.t.isf(alpha / 2, df)) * se
    change, low, high = (float(np.expm1(v)) for v in (mean, mean - half, mean + half))
    return Change(n, change, low, high, float(2 * stats.t.sf(abs(mean) / se, df)))
