"""Does the world model see at all? What a probe reads from a view's latents, against what guessing gives.

The stage `controller` asks it before it searches, and `ranking` before it compares.

The VAE's latent has to hold where the target is from the tip, or what follows is trained on nothing.
A multilayer perceptron is trained to read it (stage `vae`); guessing is the training mean. Both are root mean
squared distances on held-out episodes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract.errors import BelvedereError
from pipeline.storage.artefacts import read_json

PARTS = {"tip": "tip_m", "target": "target_m"}
WHOLE, WHOLE_ENTRY = "tip - target", "tip_to_target_m"


@dataclass(frozen=True)
class Sight:
    """What the latents of a view tell.

    Attributes:
        probe_m: error of the probe of tip - target, mean over the first repeats.
        guess_m: of guessing it.
        misses: empty if it sees; else which of ``tip`` and ``target`` the latent lacks, or
            ``tip - target`` where each by itself is there.
    """

    probe_m: float
    guess_m: float
    misses: list[str]


def read_sight(file: Path, key: str, first: int, share: float) -> Sight:
    """Judges branch ``key`` by the first repeats of its ``vae.json``.

    Args:
        file: the metrics of its first network.
        key: the branch.
        first: how many repeats count: always the same ones, so that more repeats decide nothing again.
        share: of guessing's error, above which something is not seen.

    Raises:
        BelvedereError: the file is missing, or lacks a number.
    """
    content = read_json(file, f"vae@{key}")
    entries = {**PARTS, WHOLE: WHOLE_ENTRY}
    errors = {name: _errors(content, entry, first) for name, entry in entries.items()}
    unread = [name for name, found in errors.items() if not np.isfinite(found).all()]
    if unread:
        raise BelvedereError(
            f"{file} cannot be used: of its first {first} repeats it does not say how well a probe and a "
            f"guess tell {unread[0]}; `dvc repro vae@{key}` makes it."
        )
    seen = {name: probe <= share * guess for name, (probe, guess) in errors.items()}
    lacking = [name for name in PARTS if not seen[name]] or [WHOLE]
    probe, guess = errors[WHOLE]
    return Sight(probe, guess, [] if seen[WHOLE] else lacking)


def _errors(content: Mapping[str, Any], entry: str, first: int) -> tuple[float, float]:
    """Mean errors of probe and guess over the first repeats; NaN where one is lacking."""
    names = (f"probe_mlp_{entry}", f"guess_{entry}")
    try:
        rows = {row["repeat"]: row for row in content["repeats"]}
        probe, guess = (float(np.mean([float(rows[r][name]) for r in range(first)])) for name in names)
    except (KeyError, TypeError, ValueError):
        return np.nan, np.nan
    return probe, guess
