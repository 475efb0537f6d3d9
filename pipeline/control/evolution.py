"""CMA-ES (Hansen 2016; pycma), resumable to the bit."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cma
import numpy as np
import polars as pl

from pipeline.contract.artefacts import writing
from pipeline.contract.errors import BelvedereError
from pipeline.contract.progress import Progress
from pipeline.control.params import SearchParams

Judge = Callable[[np.ndarray, np.random.Generator], np.ndarray]


@dataclass
class Normal:
    """pycma's source of normal draws: our own generator, so that NumPy's global one is left alone."""

    rng: np.random.Generator

    def __call__(self, *shape: int) -> np.ndarray:
        return self.rng.standard_normal(shape)


@dataclass
class Search:
    """A search and how far it has come; all of it is in a checkpoint.

    Attributes:
        strategy: pycma's state.
        draws: what the judge draws episodes from, generation by generation.
        curve: of each generation its number and the population's mean and best return.
    """

    strategy: Any
    draws: np.random.Generator
    curve: list[tuple[int, float, float]] = field(default_factory=list)

    @property
    def incumbent(self) -> np.ndarray:
        """The last generation's distribution mean: no candidate is picked by its luck."""
        return np.array(self.strategy.mean)

    def table(self, frames: int) -> pl.DataFrame:
        """The curve with columns ``generation``, ``frames`` (so far, of so many each), ``mean``, ``best``."""
        rows = pl.DataFrame(self.curve, schema=["generation", "mean", "best"], orient="row")
        return rows.insert_column(1, ((rows["generation"] + 1) * frames).alias("frames"))


def start(
    first: np.ndarray,
    population: int,
    method: SearchParams,
    rng: np.random.Generator,
    draws: np.random.Generator,
    shares: np.ndarray | None = None,
) -> Search:
    """A search about a first point.

    Args:
        first: the point, shape (d,).
        population: candidates of a generation.
        method: first standard deviation, form of the covariance.
        rng: draws candidates.
        draws: is for the judge.
        shares: of the first standard deviation, by coordinate, shape (d,); None is all of it.
    """
    options = {
        "popsize": population,
        "randn": Normal(rng),
        "seed": np.nan,  # pycma seeds nothing
        "CMA_diagonal": method.diagonal,
        "CMA_stds": shares,
        "verbose": -9,
        "verb_log": 0,
        "verb_disp": 0,
    }
    return Search(cma.CMAEvolutionStrategy(first, method.sigma, options), draws)


def evolve(search: Search, judge: Judge, generations: int, running: Path, what: str) -> Search:
    """Runs a search up to so many generations.

    Args:
        search: where to start; a checkpoint in ``running`` takes its place.
        judge: returns (p,), to be maximised, of candidates (p, d); draws from the given generator alone.
        generations: of the whole search.
        running: folder of the checkpoint, written after each generation; what was killed continues
            to the same bytes.
        what: the progress bar's words.

    Raises:
        BelvedereError: a return is not a finite number.
    """
    checkpoint = Path(running) / "search.pickle"
    if checkpoint.is_file():
        search = pickle.loads(checkpoint.read_bytes())
    with Progress(generations, what, initial=len(search.curve)) as progress:
        while len(search.curve) < generations:
            candidates = np.array(search.strategy.ask())
            returns = judge(candidates, search.draws)
            if not np.isfinite(returns).all():
                raise BelvedereError(f"{what}: a return is {returns.min()}; look at the stage's input.")
            search.strategy.tell(list(candidates), list(-returns))
            search.curve.append((len(search.curve), float(returns.mean()), float(returns.max())))
            with writing(checkpoint) as aside:
                aside.write_bytes(pickle.dumps(search))
            progress.advance(mean=f"{returns.mean():.2f}", best=f"{returns.max():.2f}")
    return search
