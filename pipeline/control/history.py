"""A search's checkpoint: what its generations returned, from which the search is repeated.

pycma has no format for its state but pickle, which runs the code that a file holds. Candidates are drawn
from a seeded generator, so the returns are all that a search cannot know again without simulation.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeline.storage.archives import read_whole
from pipeline.storage.artefacts import writing

FILE = "search.npz"


def write_history(path: Path, returns: Sequence[np.ndarray], draws: np.random.Generator) -> None:
    """Writes the returns (p,) of each generation, and how far the evaluation's draws have come."""
    state = json.dumps(draws.bit_generator.state)
    with writing(path) as aside, aside.open("wb") as file:
        np.savez(file, returns=np.stack(returns), draws=np.array(state))


def read_history(path: Path, population: int, draws: np.random.Generator) -> np.ndarray:
    """The returns (g, p) of the generations so far; sets ``draws`` to where they ended.

    Raises:
        Exception: of many types, where the file is damaged or of another search; ``draws`` are then as they
            were.
    """
    with np.load(read_whole(path), allow_pickle=False) as arrays:
        returns, state = arrays["returns"], json.loads(str(arrays["draws"]))
    if returns.dtype.kind != "f" or returns.shape[1:] != (population,) or not np.isfinite(returns).all():
        raise ValueError(f"returns of shape {returns.shape}, population {population}")
    draws.bit_generator.state = state
    return np.asarray(returns)
