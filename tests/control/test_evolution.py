from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.control.evolution import Search, evolve, start
from pipeline.control.params import SearchParams

DIMENSIONS, GENERATIONS = 12, 30


def search(diagonal: bool = True) -> Search:
    rng = np.random.default_rng(3)
    candidates, draws = rng.spawn(2)
    method = SearchParams(sigma=0.3, diagonal=diagonal)
    return start(np.zeros(DIMENSIONS), 8, method, candidates, draws)


def noisy_sphere(candidates: np.ndarray, draws: np.random.Generator) -> np.ndarray:
    """Best at 1, 1, …; every generation draws noise of its own, as it draws episodes."""
    return -np.square(candidates - 1.0).sum(axis=1) + 0.01 * draws.standard_normal(len(candidates))


@pytest.mark.parametrize("diagonal", [True, False])
def test_it_climbs(diagonal: bool, tmp_path: Path) -> None:
    found = evolve(search(diagonal), noisy_sphere, 60, tmp_path, "test")
    assert np.square(found.incumbent - 1.0).sum() < 0.1 * DIMENSIONS
    assert [generation for generation, _, _ in found.curve] == list(range(60))
    assert all(best >= mean for _, mean, best in found.curve)


def test_what_was_killed_continues_to_the_same_bytes(tmp_path: Path) -> None:
    whole = evolve(search(), noisy_sphere, GENERATIONS, tmp_path / "whole", "test")
    calls = 0

    def killed(candidates: np.ndarray, draws: np.random.Generator) -> np.ndarray:
        nonlocal calls
        calls += 1
        if calls == GENERATIONS // 2:
            draws.standard_normal(100)  # half a generation's draws are lost with it
            raise KeyboardInterrupt
        return noisy_sphere(candidates, draws)

    with pytest.raises(KeyboardInterrupt):
        evolve(search(), killed, GENERATIONS, tmp_path / "parts", "test")
    resumed = evolve(search(), noisy_sphere, GENERATIONS, tmp_path / "parts", "test")
    assert resumed.incumbent.tobytes() == whole.incumbent.tobytes()
    assert resumed.curve == whole.curve


def test_numpys_own_generator_is_left_alone(tmp_path: Path) -> None:
    np.random.seed(5)  # noqa: NPY002
    expected = np.random.random(3)  # noqa: NPY002
    np.random.seed(5)  # noqa: NPY002
    evolve(search(), noisy_sphere, 2, tmp_path, "test")
    np.testing.assert_array_equal(np.random.random(3), expected)  # noqa: NPY002


def test_a_return_that_is_no_number_is_told(tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match="a return is nan"):
        evolve(search(), lambda candidates, _: np.full(len(candidates), np.nan), 1, tmp_path, "test")
