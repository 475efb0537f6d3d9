"""CMA-ES (Hansen 2016; pycma), resumable to the bit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cma
import numpy as np
import polars as pl

from pipeline.contract.errors import BelvedereError
from pipeline.contract.progress import Progress
from pipeline.control import history
from pipeline.control.params import SearchParams


@dataclass(frozen=True, eq=False)
class Generation:
    """One generation of a search, to be evaluated.

    Attributes:
        member: which of the searches that run side by side.
        candidates: shape (p, d).
        draws: what the evaluation draws from, for this search alone.
    """

    member: int
    candidates: np.ndarray
    draws: np.random.Generator


Evaluate = Callable[[Sequence[Generation]], Iterable[np.ndarray]]


@dataclass
class Normal:
    """pycma's source of normal draws: our own generator, so that NumPy's global one is left alone."""

    rng: np.random.Generator

    def __call__(self, *shape: int) -> np.ndarray:
        return self.rng.standard_normal(shape)


@dataclass
class Search:
    """A search and how far it has come.

    Attributes:
        strategy: pycma's state.
        draws: what the evaluation draws episodes from, generation by generation.
        returns: of each generation, (p,).
    """

    strategy: Any
    draws: np.random.Generator
    returns: list[np.ndarray] = field(default_factory=list)

    @property
    def curve(self) -> list[tuple[int, float, float]]:
        """Of each generation its number and the population's mean and best return."""
        return [(g, float(own.mean()), float(own.max())) for g, own in enumerate(self.returns)]

    @property
    def incumbent(self) -> np.ndarray:
        """The last generation's distribution mean: no candidate is picked by its luck."""
        return np.array(self.strategy.mean)

    def ask(self, member: int) -> Generation:
        """The next generation's candidates."""
        return Generation(member, np.array(self.strategy.ask()), self.draws)

    def tell(self, candidates: np.ndarray, returns: np.ndarray) -> None:
        """Moves on by the returns (p,) of candidates (p, d)."""
        self.strategy.tell(list(candidates), list(-returns))
        self.returns.append(np.array(returns))

    def table(self, frames: int) -> pl.DataFrame:
        """The curve with columns ``generation``, ``frames`` (so far, of so many each), ``mean``, ``best``."""
        rows = pl.DataFrame(self.curve, schema=["generation", "mean", "best"], orient="row")
        return rows.insert_column(1, ((rows["generation"] + 1) * frames).alias("frames"))


@dataclass(frozen=True, eq=False)
class Run:
    """A search on its way.

    Attributes:
        search: where to start.
        running: folder of the checkpoint, written after each generation; what was killed continues
            to the same bytes.
        name: for messages.
    """

    search: Search
    running: Path
    name: str

    def so_far(self) -> Search:
        """The search moved on to the last checkpoint; a damaged one is skipped, with a message."""
        if self._checkpoint.is_file():
            population = int(self.search.strategy.popsize)
            try:
                known = history.read_history(self._checkpoint, population, self.search.draws)
            except Exception as error:  # a damaged file surfaces as one of many types
                print(f"{self._checkpoint} is damaged ({type(error).__name__}); {self.name} starts again.")
                return self.search
            for returns in known:
                self.search.tell(self.search.ask(0).candidates, returns)
        return self.search

    def advance(self, search: Search, generation: Generation, returns: np.ndarray) -> None:
        """Moves ``search`` on by an evaluated generation and writes the checkpoint."""
        if not np.isfinite(returns).all():
            raise BelvedereError(f"{self.name}: a return is {returns.min()}; look at the stage's input.")
        search.tell(generation.candidates, returns)
        history.write_history(self._checkpoint, search.returns, search.draws)

    @property
    def _checkpoint(self) -> Path:
        return Path(self.running) / history.FILE


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
        draws: is for the evaluation.
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


def evolve(runs: Sequence[Run], evaluate: Evaluate, generations: int, what: str) -> list[Search]:
    """Runs searches side by side, one generation of each at a time, up to so many generations.

    Each search has its own draws and its own checkpoint, so it ends with the same bytes whichever
    others run beside it; after a kill some may be a generation ahead of the rest.

    Args:
        runs: the searches.
        evaluate: returns, of each generation that it is given, (p,) to be maximised; draws from the
            generation's own generator alone.
        generations: of each whole search.
        what: the progress bar's words.

    Raises:
        BelvedereError: a return is not a finite number.
    """
    searches = [run.so_far() for run in runs]
    done = sum(len(search.returns) for search in searches)
    with Progress(generations * len(runs), what, initial=done) as progress:
        while behind := [i for i, search in enumerate(searches) if len(search.returns) < generations]:
            asked = [searches[i].ask(member=i) for i in behind]
            evaluated = list(evaluate(asked))
            for generation, returns in zip(asked, evaluated, strict=True):
                runs[generation.member].advance(searches[generation.member], generation, returns)
            mean, best = np.mean(evaluated), np.max(evaluated)
            progress.advance(len(asked), mean=f"{mean:.2f}", best=f"{best:.2f}")
    return searches
