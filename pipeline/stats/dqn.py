"""What the deep Q-networks of a scene reached, as the stage `dqn` left it; none where none was trained."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract.errors import BelvedereError
from pipeline.storage.artefacts import read_json

_NUMBERS = ("return", "expert_return")


@dataclass(frozen=True)
class DqnResults:
    """The networks of the views that have some.

    Attributes:
        keys: the branches.
        returns: (view, repeat) mean return, paper eq. (2), of an evaluation episode.
        restricted_expert: (repeat,) the same of the expert who has only the network's actions.
    """

    keys: list[str]
    returns: np.ndarray
    restricted_expert: np.ndarray


def read_dqn(folder: Path, keys: Sequence[str]) -> DqnResults | None:
    """Reads ``{folder}/{key}/dqn.json`` of the branches that have one with trained networks.

    Raises:
        BelvedereError: a file is foreign, or branches differ in their number of repeats.
    """
    files = {key: folder / key / "dqn.json" for key in keys}
    contents = {key: read_json(file, f"dqn@{key}") for key, file in files.items() if file.is_file()}
    rows = {key: _rows(files[key], key, content) for key, content in contents.items()}
    rows = {key: numbers for key, numbers in rows.items() if len(numbers)}
    counts = {key: len(numbers) for key, numbers in rows.items()}
    if len(set(counts.values())) > 1:
        raise BelvedereError(
            f"the deep Q-networks have different numbers of repeats ({counts}); `dvc repro` brings all to "
            "the budget's number."
        )
    if not rows:
        return None
    table = np.array(list(rows.values()))  # (view, repeat, number)
    return DqnResults(list(rows), table[..., 0], table[0, :, 1])


def _rows(file: Path, key: str, content: Mapping[str, Any]) -> np.ndarray:
    try:
        ordered = sorted(content["repeats"], key=lambda row: int(row["repeat"]))
        rows = np.array([[float(row[name]) for name in _NUMBERS] for row in ordered])
    except (KeyError, TypeError, ValueError) as error:
        raise _foreign(file, key, f"its repeats lack a number ({error})") from None
    if not np.isfinite(rows).all():
        raise _foreign(file, key, "a number in its repeats is not finite")
    return rows


def _foreign(file: Path, key: str, why: str) -> BelvedereError:
    return BelvedereError(f"{file} cannot be used: {why}; delete it and run `dvc repro dqn@{key}`.")
