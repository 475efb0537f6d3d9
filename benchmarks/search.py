"""`./run python -m benchmarks.search`: what a search over the sphere finds, on maps that are known.

A map is a score for each of 48 views over pan and tilt: smooth, or with an edge of occlusion behind which
scores are lower. A training's residual has σ .06 to .08, its repeat shifts all views alike. Regret: how far
the view that is said to be the best lies below the best one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import polars as pl

from pipeline.placement.params import PlacementParams
from pipeline.placement.sphere import lattice
from pipeline.stats.halving import Halving, final, halve
from pipeline.stats.race import Rules
from pipeline.stats.replay import Race
from pipeline.stats.surface import distances, matern, unit_vectors
from pipeline.stats.tails import tail

VIEWS, FINALISTS, MOST = 48, 6, 20
SHIFT, MAPS, SEED = 0.05, 300, 1
SPREADS, TOLERANCES = (0.06, 0.08), (0.1, 0.05)
HEMISPHERE = PlacementParams(
    candidates=VIEWS,
    by="lattice",
    theta_deg=(-180, 180),
    phi_deg=(0, 75),
    distance_m=None,
    fov_deg=None,
    forbidden=(),
)


def smooth(vectors: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(view,) a draw of a Gaussian process of length 0.7 (40°) and deviation .15, about .6."""
    covariance = 0.15**2 * matern(distances(vectors, vectors) / 0.7)
    return 0.6 + rng.multivariate_normal(np.zeros(len(vectors)), covariance, method="cholesky")


def edged(vectors: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A smooth map that falls by .3 behind a plane through the sphere, as if something hid the target."""
    normal = rng.standard_normal(3)
    return smooth(vectors, rng) - 0.3 * (vectors @ normal > 0.3 * np.linalg.norm(normal))


MAPS_OF = {"smooth": smooth, "edge": edged}


@dataclass(frozen=True)
class End:
    """How a search ended: trainings made, regret (score), and whether its statement was wrong."""

    trainings: int
    regret: float
    wrong: bool


def search(scores: np.ndarray, spread: float, tolerance: float, rng: np.random.Generator) -> End:
    """One search on a map (view,), by the functions that the product calls."""
    rules = Rules(3, MOST, tolerance, tail(0.95, MOST))
    shifts = rng.normal(0, SHIFT, 64)
    values: list[np.ndarray] = [np.empty(0)] * len(scores)
    while True:
        halving = halve(values, FINALISTS)
        needed, race = halving.needed, None
        if halving.done:
            race, needed = final(values, halving, rules)
            if race and race.state == "open":
                spent = len(halving.rounds) + race.last.repeats + 1
                needed = {halving.active[view]: spent for view in race.active}
        if not needed and race:
            return _end(scores, halving, race, values)
        for view, repeats in needed.items():
            draws = rng.normal(scores[view], spread, repeats - len(values[view]))
            values[view] = np.concatenate([values[view], draws + shifts[len(values[view]) : repeats]])


def _end(scores: np.ndarray, halving: Halving, race: Race, values: Sequence[np.ndarray]) -> End:
    finalists = scores[halving.active]
    chosen, best = finalists[race.leader], finalists.max()
    out = not race.last.active[int(finalists.argmax())] and best - chosen > 0
    wrong = bool(best - chosen > race.last.within or (out and best > chosen))
    return End(sum(map(len, values)), float(scores.max() - chosen), wrong)


def each_five(scores: np.ndarray, spread: float, rng: np.random.Generator) -> End:
    """Five repeats of every view, and the highest mean."""
    values = scores[:, None] + rng.normal(0, spread, (len(scores), 5))
    return End(5 * len(scores), float(scores.max() - scores[values.mean(axis=1).argmax()]), False)


def row(kind: str, spread: float, tolerance: float | None, maps: int, seed: int) -> dict[str, object]:
    """Means over maps of one kind; without a tolerance five repeats each."""
    rng, vectors = (
        np.random.default_rng([seed, round(1000 * spread)]),
        unit_vectors(lattice(HEMISPHERE, VIEWS)),
    )
    ends = []
    for _ in range(maps):
        scores = MAPS_OF[kind](vectors, rng)
        ends.append(search(scores, spread, tolerance, rng) if tolerance else each_five(scores, spread, rng))
    regrets = np.array([end.regret for end in ends])
    return {
        "map": kind,
        "sd": spread,
        "design": f"halving, race to {tolerance:g}" if tolerance else "5 repeats each",
        "maps": maps,
        "trainings": round(float(np.mean([end.trainings for end in ends])), 1),
        "regret": round(float(regrets.mean()), 4),
        "within .05": round(float((regrets <= 0.05).mean()), 3),
        "wrong": round(float(np.mean([end.wrong for end in ends])), 3),
    }


def main() -> None:
    """Prints a row for each kind of map, spread and design."""
    rows = [
        row(kind, spread, tolerance, MAPS, SEED)
        for kind in MAPS_OF
        for spread in SPREADS
        for tolerance in (None, *TOLERANCES)
    ]
    with pl.Config(tbl_rows=-1, tbl_width_chars=120):
        print(pl.DataFrame(rows))


if __name__ == "__main__":
    main()
