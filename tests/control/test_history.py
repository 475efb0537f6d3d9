"""A search's checkpoint comes back to the bit, or not at all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.control.history import read_history, write_history
from tests.damage import flipped

GENERATIONS, POPULATION = 5, 8


@pytest.fixture
def path(tmp_path: Path) -> Path:
    draws = np.random.default_rng(1)
    write_history(tmp_path / "search.npz", list(draws.normal(size=(GENERATIONS, POPULATION))), draws)
    return tmp_path / "search.npz"


def test_returns_and_draws_come_back(path: Path) -> None:
    draws, other = np.random.default_rng(1), np.random.default_rng(2)
    returns = draws.normal(size=(GENERATIONS, POPULATION))
    assert read_history(path, POPULATION, other).tobytes() == returns.tobytes()
    assert other.normal() == draws.normal()


def test_of_another_population_it_is_refused(path: Path) -> None:
    with pytest.raises(ValueError, match="population 9"):
        read_history(path, POPULATION + 1, np.random.default_rng(2))


def test_each_flipped_bit_is_refused_or_changes_nothing(path: Path) -> None:
    good, refused = path.read_bytes(), 0
    returns = np.random.default_rng(1).normal(size=(GENERATIONS, POPULATION))
    for bit in range(0, 8 * len(good), 29):
        path.write_bytes(flipped(good, bit))
        draws = np.random.default_rng(2)
        try:
            found = read_history(path, POPULATION, draws)
        except Exception:
            refused += 1
            assert draws.bit_generator.state == np.random.default_rng(2).bit_generator.state
        else:
            assert found.tobytes() == returns.tobytes()
    assert refused > 8 * len(good) / 29 / 2  # the others fell on bytes of the archive that say nothing
