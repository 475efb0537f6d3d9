from __future__ import annotations

import io
import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.control.evolution import Evaluate, Generation, Run, Search, evolve, start
from pipeline.control.params import SearchParams
from tests.damage import flipped

DIMENSIONS, GENERATIONS = 12, 30


def search(diagonal: bool = True, seed: int = 3) -> Search:
    rng = np.random.default_rng(seed)
    candidates, draws = rng.spawn(2)
    method = SearchParams(sigma=0.3, diagonal=diagonal)
    return start(np.zeros(DIMENSIONS), 8, method, candidates, draws)


def noisy_sphere(generations: Sequence[Generation]) -> list[np.ndarray]:
    """Best at 1, 1, …; every generation draws noise of its own, as it draws episodes."""
    return [
        -np.square(g.candidates - 1.0).sum(axis=1) + 0.01 * g.draws.standard_normal(len(g.candidates))
        for g in generations
    ]


def alone(search: Search, evaluate: Evaluate, generations: int, folder: Path) -> Search:
    return evolve([Run(search, folder, "test")], evaluate, generations, "test")[0]


def three(folder: Path, evaluate: Evaluate = noisy_sphere) -> list[Search]:
    """Three searches side by side."""
    runs = [Run(search(seed=seed), folder / str(seed), f"test {seed}") for seed in range(3)]
    return evolve(runs, evaluate, GENERATIONS, "test")


@pytest.mark.parametrize("diagonal", [True, False])
def test_it_climbs(diagonal: bool, tmp_path: Path) -> None:
    found = alone(search(diagonal), noisy_sphere, 60, tmp_path)
    assert np.square(found.incumbent - 1.0).sum() < 0.1 * DIMENSIONS
    assert [generation for generation, _, _ in found.curve] == list(range(60))
    assert all(best >= mean for _, mean, best in found.curve)


@pytest.mark.parametrize("diagonal", [True, False])
def test_what_was_killed_continues_to_the_same_bytes(diagonal: bool, tmp_path: Path) -> None:
    whole = alone(search(diagonal), noisy_sphere, GENERATIONS, tmp_path / "whole")
    calls = 0

    def killed(generations: Sequence[Generation]) -> list[np.ndarray]:
        nonlocal calls
        calls += 1
        if calls == GENERATIONS // 2:
            generations[0].draws.standard_normal(100)  # half a generation's draws are lost with it
            raise KeyboardInterrupt
        return noisy_sphere(generations)

    with pytest.raises(KeyboardInterrupt):
        alone(search(diagonal), killed, GENERATIONS, tmp_path / "parts")
    resumed = alone(search(diagonal), noisy_sphere, GENERATIONS, tmp_path / "parts")
    assert resumed.incumbent.tobytes() == whole.incumbent.tobytes()
    assert resumed.curve == whole.curve


def objects(content: object) -> bytes:
    """A NumPy archive of the names that a checkpoint has, which holds pickled objects."""
    file = io.BytesIO()
    np.savez(file, returns=np.array([content], dtype=object), draws=np.array([content], dtype=object))
    return file.getvalue()


@pytest.mark.parametrize("write", [pickle.dumps, objects])
def test_a_checkpoint_that_holds_code_does_not_run_it(
    write: Callable[[object], bytes], tmp_path: Path
) -> None:
    class Touches:
        def __reduce__(self) -> tuple[Callable[[Path], None], tuple[Path]]:
            return Path.touch, (tmp_path / "touched",)

    alone(search(), noisy_sphere, 2, tmp_path / "search")
    for checkpoint in (tmp_path / "search").iterdir():
        checkpoint.write_bytes(write(Touches()))
    alone(search(), noisy_sphere, 3, tmp_path / "search")
    assert not (tmp_path / "touched").exists()


def test_a_damaged_checkpoint_is_passed_over_with_a_word(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whatever happens to a checkpoint, the search ends with the undisturbed one's bytes."""
    whole = alone(search(), noisy_sphere, 6, tmp_path / "whole")
    alone(search(), noisy_sphere, 3, tmp_path / "parts")
    (checkpoint,) = (tmp_path / "parts").iterdir()
    good = checkpoint.read_bytes()
    for damaged in (b"", good[: len(good) // 2], b"junk", flipped(good, 4 * len(good))):
        checkpoint.write_bytes(damaged)
        ended = alone(search(), noisy_sphere, 6, tmp_path / "parts")
        assert "is damaged" in capsys.readouterr().out
        assert ended.incumbent.tobytes() == whole.incumbent.tobytes()
        assert ended.curve == whole.curve
        checkpoint.unlink()


def test_a_search_ends_with_the_same_bytes_alone_and_beside_others(tmp_path: Path) -> None:
    asked: list[int] = []

    def counted(generations: Sequence[Generation]) -> list[np.ndarray]:
        asked.append(len(generations))
        return noisy_sphere(generations)

    for seed, found in enumerate(three(tmp_path / "beside", counted)):
        single = alone(search(seed=seed), noisy_sphere, GENERATIONS, tmp_path / f"alone {seed}")
        assert found.incumbent.tobytes() == single.incumbent.tobytes()
        assert found.curve == single.curve
    assert asked == [3] * GENERATIONS  # one call a generation


def test_killed_between_the_checkpoints_of_two_searches_they_end_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, advance, calls = three(tmp_path / "whole"), Run.advance, 0

    def killed(run: Run, *state: Any) -> None:
        nonlocal calls
        calls += 1
        if calls == 3 * (GENERATIONS // 2) + 2:  # the first search is a generation ahead of the others
            raise KeyboardInterrupt
        advance(run, *state)

    monkeypatch.setattr(Run, "advance", killed)
    with pytest.raises(KeyboardInterrupt):
        three(tmp_path / "parts")
    monkeypatch.undo()
    reached = [len(Run(search(), tmp_path / "parts" / str(s), "").so_far().curve) for s in range(3)]
    assert reached == [GENERATIONS // 2 + 1, GENERATIONS // 2, GENERATIONS // 2]
    for resumed, expected in zip(three(tmp_path / "parts"), whole, strict=True):
        assert resumed.incumbent.tobytes() == expected.incumbent.tobytes()
        assert resumed.curve == expected.curve


def test_numpys_own_generator_is_left_alone(tmp_path: Path) -> None:
    np.random.seed(5)  # noqa: NPY002
    expected = np.random.random(3)  # noqa: NPY002
    np.random.seed(5)  # noqa: NPY002
    alone(search(), noisy_sphere, 2, tmp_path)
    np.testing.assert_array_equal(np.random.random(3), expected)  # noqa: NPY002


def test_a_return_that_is_no_number_is_told(tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match="test: a return is nan"):
        alone(search(), lambda generations: [np.full(8, np.nan) for _ in generations], 1, tmp_path)
