"""Every random draw's origin: one root seed, split by repeat and by purpose.

Streams of different purposes never overlap, so nothing is selected on evaluation episodes; the
same repeat draws the same numbers in every view of a scene, so views are compared in blocks.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Stream(IntEnum):
    """What a draw is for. Values are part of the data: never renumber."""

    ROLLOUTS = 1
    VAE = 2
    PROBES = 3
    MDNRNN = 4
    EVOLUTION = 5
    TRAINING_EPISODES = 6
    EVALUATION_EPISODES = 7
    BLIND = 8
    DQN = 9
    DQN_EPISODES = 10
    CANDIDATES = 11


def sequence(seed: int, repeat: int, stream: Stream) -> np.random.SeedSequence:
    """The seed sequence of one repeat and purpose."""
    return np.random.SeedSequence(entropy=seed, spawn_key=(repeat, int(stream)))


def generator(seed: int, repeat: int, stream: Stream) -> np.random.Generator:
    """A NumPy generator for one repeat and purpose."""
    return np.random.Generator(np.random.PCG64(sequence(seed, repeat, stream)))


def integer(seed: int, repeat: int, stream: Stream) -> int:
    """A 63-bit seed for libraries that want an integer (torch, pycma)."""
    return int(sequence(seed, repeat, stream).generate_state(1, np.uint64)[0] >> 1)
