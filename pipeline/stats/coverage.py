"""How often a race's statements are right, on populations that are normal and on some that are not.

The first view is a best one: it leads all others, which are alike, by a stated gap. Of a tie, gap 0, it
counts as the best by a hair, so that to eliminate it is an error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.stats.race import Error, Look, Rules, look, no_error, with_repeat

Population = Callable[[np.random.Generator, tuple[int, ...]], np.ndarray]


def normal(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """The model's own assumption."""
    return rng.standard_normal(shape)


def skewed(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Exponential, turned over: most trainings come near the best, some fall far short."""
    return 1.0 - rng.exponential(size=shape)


def failing(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Two kinds of training: one in five fails, six standard deviations below the others."""
    return rng.standard_normal(shape) + 1.2 - 6.0 * (rng.random(shape) < 0.2)


POPULATIONS: dict[str, Population] = {"normal": normal, "skewed": skewed, "failing": failing}


@dataclass(frozen=True)
class Ends:
    """How races ended; all arrays (race,).

    Attributes:
        wrong: whether a best view was eliminated, or is further above the leader than U.
        covered: whether the leader's true lead lies in its interval.
        trainings: how many were made.
        repeats: of the views that were left.
        leader: index of the view that led.
        within: U.
        high: upper end of the leader's interval.
    """

    wrong: np.ndarray
    covered: np.ndarray
    trainings: np.ndarray
    repeats: np.ndarray
    leader: np.ndarray
    within: np.ndarray
    high: np.ndarray


def draw(
    population: Population,
    views: int,
    gap: float,
    spread: float,
    races: int,
    most: int,
    rng: np.random.Generator,
) -> np.ndarray:
    """(race, view, repeat) residuals of the population times ``spread``, and shifts that repeats share."""
    shifts = rng.standard_normal((races, 1, most))
    values = spread * (population(rng, (races, views, most)) + shifts)
    values[:, 0] += gap
    return values


def run(values: np.ndarray, means: np.ndarray, rules: Rules) -> Ends:
    """All races at once.

    Args:
        values: (race, view, repeat), each with rules.most repeats.
        means: (view,) the true means, the first one a highest.
        rules: of the races.
    """
    races, views, _ = values.shape
    going, active = np.arange(races), np.ones((races, views), dtype=bool)
    error, above = no_error((races,)), np.full((races, views, views), np.inf)
    trainings, parts = np.zeros(races, dtype=int), []
    for repeats in range(1, rules.most + 1):
        seen = values[going, :, :repeats]
        error = with_repeat(error, seen, active)
        trainings[going] += active.sum(axis=1)
        if repeats < rules.first:
            continue
        found = look(seen, active, error, views, rules.probability)
        above[going] = np.where(_both(found), _upper(found), above[going])
        done = (found.active.sum(axis=1) == 1) | (found.within <= rules.tolerance) | (repeats == rules.most)
        parts.append((going[done], _ends(found, done, means, above[going], trainings[going])))
        going, active = going[~done], found.active[~done]
        error = Error(error.squares[~done], error.df[~done])
        if not len(going):
            break
    order = np.argsort(np.concatenate([index for index, _ in parts]))
    columns = zip(*[ends for _, ends in parts], strict=True)
    return Ends(*(np.concatenate(column)[order] for column in columns))


def _both(found: Look) -> np.ndarray:
    return np.asarray(found.entered[..., :, None] & found.entered[..., None, :])


def _upper(found: Look) -> np.ndarray:
    """(…, i, j) the most by which i can be above j."""
    return np.asarray(found.means[..., :, None] - found.means[..., None, :] + found.half_widths)


def _ends(
    found: Look, done: np.ndarray, means: np.ndarray, above: np.ndarray, trainings: np.ndarray
) -> tuple[np.ndarray, ...]:
    """The fields of :class:`Ends` of the races that are done."""
    leader, within = found.leader[done], found.within[done]
    others = np.where(np.eye(len(means), dtype=bool), np.inf, above[done])
    high = others[np.arange(len(leader)), leader].min(axis=1).clip(min=0.0)
    true = np.where(leader == 0, means[0] - np.delete(means, 0).max(), means[leader] - means[0])
    wrong = ~found.active[done, 0] | (means[0] - means[leader] > within)
    covered = (-within <= true) & (true <= high)
    return wrong, covered, trainings[done], np.full(len(leader), found.repeats), leader, within, high
