"""Tables by repeat as stages left them, checked: no gap in the repeats, finite numbers, one provenance."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract.errors import BelvedereError, unknown

# Threads, processor and Python leave results alone (batches are bit-identical at any thread count);
# these do not. The anchors have no network and no pictures, so only the physics has to agree.
COMPARED = ("device", "gpu", "dtype", "torch", "mujoco", "mujoco_warp")
COMPARED_WITH_ANCHORS = ("mujoco",)
CHOSEN = ("device", "dtype")  # by the environment variables of these names
MIX_VARIABLE = "BELVEDERE_MIX"  # an environment variable: where a result was made is no parameter


def by_repeat(file: Path, content: Mapping[str, Any], names: tuple[str, ...], made_by: str) -> np.ndarray:
    """(repeat, number) the numbers ``names`` of repeats 0, 1, … of ``content``, which is that of ``file``.

    Raises:
        BelvedereError: there are none, one is lacking, or a number is none; names the stage ``made_by``.
    """
    try:
        table = {int(r["repeat"]): tuple(float(r[name]) for name in names) for r in content["repeats"]}
        count = len(content["repeats"])
    except (KeyError, TypeError, ValueError) as error:
        raise foreign(file, f"its repeats lack a number ({error})", made_by) from None
    if not table or len(table) < count:
        raise foreign(file, "its repeats are none or not distinct", made_by)
    if sorted(table) != list(range(count)):
        raise foreign(file, f"its repeats are {sorted(table)}, not 0 to {count - 1} without a gap", made_by)
    if not np.all(np.isfinite(list(table.values()))):
        raise foreign(file, f"a {' or '.join(names)} in its repeats is not finite", made_by)
    return np.array([table[repeat] for repeat in range(count)])


def check_viewpoint(
    file: Path, content: Mapping[str, Any], meant: tuple[str, float, float], made_by: str
) -> None:
    """Refuses a file of another viewpoint.

    Args:
        file: of which ``content`` is the content.
        content: with ``scene``, ``theta_deg`` and ``phi_deg``.
        meant: the same three of params.yaml.
        made_by: the stage that writes the file.

    Raises:
        BelvedereError: it is of another, or does not say.
    """
    found = tuple(content.get(name) for name in ("scene", "theta_deg", "phi_deg"))
    if found != meant:
        raise foreign(file, f"it is of {found}, but params.yaml says {meant}", made_by)


def provenance(file: Path, content: Mapping[str, Any], made_by: str) -> dict[str, Any]:
    """What a file was made with.

    Raises:
        BelvedereError: it does not say.
    """
    made = content.get("provenance")
    if not isinstance(made, dict):
        raise foreign(file, "it does not say what it was made with", made_by)
    return made


def check_made_alike(scene: str, made: Mapping[str, Mapping[str, Any]], names: tuple[str, ...]) -> None:
    """Refuses results of one scene that differ in one of ``names``.

    Raises:
        BelvedereError: they do.
    """
    (first, here), *others = made.items()
    for key, there in others:
        for name in names:
            if there.get(name) != here.get(name):
                by = f"BELVEDERE_{name.upper()}={here.get(name)} " if name in CHOSEN else ""
                raise BelvedereError(
                    f"scene {scene} was made differently: {name} is {there.get(name)!r} for {key} but "
                    f"{here.get(name)!r} for {first}; rerun one of them as the other was made "
                    f"(`{by}dvc repro`), or set BELVEDERE_MIX=allow to rank them nevertheless."
                )


def mixture_allowed() -> bool:
    """Whether results may be compared that were made on different devices or versions.

    Raises:
        BelvedereError: the environment variable has another value than ``allow``.
    """
    word = os.environ.get(MIX_VARIABLE, "")
    if word not in ("", "allow"):
        raise unknown(f"environment variable {MIX_VARIABLE}: value", word, ["allow"])
    return word == "allow"


def foreign(file: Path, why: str, made_by: str) -> BelvedereError:
    """The error for a file that is not what its stage writes."""
    return BelvedereError(f"{file} cannot be used: {why}; delete it and run `dvc repro {made_by}`.")
