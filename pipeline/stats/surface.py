"""A surface through scores on the sphere, for the eye: a Gaussian process on the camera's direction.

y of view i in repeat r is m + f(x_i) + b_r + ε: f has a Matérn 5/2 covariance in the distance of unit
vectors, so there is no seam at 0°/360° and none at the pole; b_r is what a repeat gives all views alike.
Hyperparameters are averaged over a grid, weighted by the likelihood. C. E. Rasmussen and C. K. I. Williams,
Gaussian Processes for Machine Learning (2006), eqs (2.25), (2.26), (2.30) and (4.17). Its own certainty is
not to be trusted.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

LENGTHS = (0.2, 0.35, 0.6, 1.0, 1.7)  # of unit vectors' distances: 0.35 is 20°
SIGNALS = (0.05, 0.1, 0.2, 0.4)  # standard deviation of f, score
NOISES = (0.02, 0.04, 0.08, 0.16)  # of one repeat
STEP_DEG = 5
_LEVEL = 1.0  # prior standard deviation of m
_BLOCK = 0.1  # of b_r
_CENTRE = 0.5  # prior mean of m


@dataclass(frozen=True)
class Surface:
    """Posterior mean and standard deviation of m + f at some directions, each (n,)."""

    mean: np.ndarray
    sd: np.ndarray


def unit_vectors(directions: Sequence[tuple[float, float]] | np.ndarray) -> np.ndarray:
    """(n, 3) unit vectors towards the camera, of pans and tilts (n, 2), degrees."""
    theta, phi = np.radians(np.asarray(directions, dtype=float).reshape(-1, 2)).T
    return np.stack([np.cos(phi) * np.cos(theta), np.cos(phi) * np.sin(theta), np.sin(phi)], axis=1)


def grid(directions: Sequence[tuple[float, float]]) -> np.ndarray:
    """(n, 2) pans and tilts every five degrees over the range of some, whole degrees."""
    around = np.asarray(directions, dtype=float)
    low, high = np.floor(around.min(axis=0) / STEP_DEG), np.ceil(around.max(axis=0) / STEP_DEG)
    pans, tilts = (STEP_DEG * np.arange(a, b + 1) for a, b in zip(low, high, strict=True))
    return np.array([(theta, phi) for phi in tilts for theta in pans], dtype=int)


def surface(vectors: np.ndarray, repeats: np.ndarray, scores: np.ndarray, at: np.ndarray) -> Surface:
    """The surface at directions.

    Args:
        vectors: (n, 3) unit vectors of the trainings' views.
        repeats: (n,) the number of each one's repeat.
        scores: (n,) of the trainings.
        at: (m, 3) unit vectors of where it is wanted.
    """
    near, far = distances(vectors, vectors), distances(at, vectors)
    block = _BLOCK**2 * (repeats[:, None] == repeats[None]) + _LEVEL**2
    means, variances, weights = [], [], []
    for length, signal, noise in itertools.product(LENGTHS, SIGNALS, NOISES):
        covariance = signal**2 * matern(near / length) + block + noise**2 * np.eye(len(scores))
        across = signal**2 * matern(far / length) + _LEVEL**2
        factor = linalg.cho_factor(covariance, lower=True)
        centred = scores - _CENTRE
        solved = linalg.cho_solve(factor, centred)
        means.append(_CENTRE + across @ solved)
        reduced = np.einsum("mn,nm->m", across, linalg.cho_solve(factor, across.T))
        variances.append(np.maximum(signal**2 + _LEVEL**2 - reduced, 0.0))
        weights.append(-0.5 * centred @ solved - np.log(np.diag(factor[0])).sum())
    shares = np.exp(np.array(weights) - max(weights))
    shares /= shares.sum()
    mean = shares @ np.array(means)
    spread = shares @ (np.array(variances) + np.array(means) ** 2) - mean**2
    return Surface(mean, np.sqrt(np.maximum(spread, 0.0)))


def distances(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(n, 3) and (m, 3) → (n, m) lengths of the chords between unit vectors."""
    return np.sqrt(np.maximum(2.0 - 2.0 * first @ second.T, 0.0))


def matern(distance: np.ndarray) -> np.ndarray:
    """The Matérn 5/2 correlation at distances in units of its length."""
    scaled = 5**0.5 * distance
    return np.asarray((1 + scaled + scaled**2 / 3) * np.exp(-scaled))
