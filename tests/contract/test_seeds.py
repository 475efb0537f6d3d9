"""Draws of different purposes and repeats are different, and those of the same never change."""

from __future__ import annotations

import ast
import itertools
from pathlib import Path

import numpy as np
import pytest

from pipeline.contract.seeds import Stream, generator, integer, sequence

PIPELINE = Path(__file__).resolve().parents[2] / "pipeline"
ALL = list(itertools.product((0, 1), range(4), Stream))


def test_no_two_streams_share_a_number() -> None:
    drawn = [generator(*which).integers(0, 2**63, size=500) for which in ALL]
    assert len(np.unique(np.concatenate(drawn))) == sum(len(numbers) for numbers in drawn)


def test_integers_for_libraries_differ_too_and_are_non_negative() -> None:
    drawn = {integer(*which) for which in ALL}
    assert len(drawn) == len(ALL)
    assert all(0 <= number < 2**63 for number in drawn)


def test_streams_are_uncorrelated() -> None:
    samples = np.stack([generator(1, repeat, s).normal(size=4000) for repeat in range(3) for s in Stream])
    correlation = np.corrcoef(samples) - np.eye(len(samples))
    assert np.abs(correlation).max() < 5 / np.sqrt(4000)


def test_a_stream_is_the_same_each_time_it_is_asked_for() -> None:
    first, second = (generator(1, 2, Stream.VAE).normal(size=10) for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("stream", Stream)
def test_a_stream_is_numpys_own_child_of_the_root(stream: Stream) -> None:
    """NumPy promises SeedSequence's and PCG64's numbers, so artefacts stay comparable over the years."""
    child = np.random.SeedSequence(1, spawn_key=(3, stream.value))
    np.testing.assert_array_equal(sequence(1, 3, stream).generate_state(8), child.generate_state(8))
    expected = np.random.Generator(np.random.PCG64(child)).random(4)
    np.testing.assert_array_equal(generator(1, 3, stream).random(4), expected)


def test_the_numbers_of_the_streams_are_part_of_the_data() -> None:
    assert {stream.name: stream.value for stream in Stream} == {
        "ROLLOUTS": 1,
        "VAE": 2,
        "PROBES": 3,
        "MDNRNN": 4,
        "EVOLUTION": 5,
        "TRAINING_EPISODES": 6,
        "EVALUATION_EPISODES": 7,
        "BLIND": 8,
        "DQN": 9,
        "DQN_EPISODES": 10,
        "CANDIDATES": 11,
    }


@pytest.mark.parametrize("stream", Stream)
def test_a_stream_has_one_purpose(stream: Stream) -> None:
    """One place that makes results draws from it; preview and checks look at the rollouts themselves.

    Ablations begin where the training began of which they leave a part out, so they draw what it drew.
    """
    others = ("checks", "ablations")
    sources = [f for f in PIPELINE.rglob("*.py") if f.name != "preview.py" and f.parent.name not in others]
    places = [
        f"{file.relative_to(PIPELINE)}:{node.lineno}"
        for file in sources
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and ast.unparse(node).endswith(f"Stream.{stream.name}")
    ]
    assert len(places) == 1, places
