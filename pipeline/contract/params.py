"""Reading params.yaml, section by section.

Each section's model lives beside its consumer and derives from :class:`Section`; this module only
knows how to read one and how to say, in a sentence, what is wrong with it.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from pipeline.contract.errors import BelvedereError, unknown

PARAMS_FILE = Path("params.yaml")


class Section(BaseModel):
    """A frozen section of params.yaml: unknown keys and wrong types are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


SectionT = TypeVar("SectionT", bound=Section)


@lru_cache(maxsize=4)
def _tree(path: Path, mtime_ns: int) -> dict[str, Any]:
    try:
        tree = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise BelvedereError(f"{path} is not valid YAML: {' '.join(str(error).split())}.") from None
    if not isinstance(tree, dict):
        raise BelvedereError(f"{path} holds no mapping of parameters at its top level.")
    return tree


def value(*keys: str, path: Path = PARAMS_FILE) -> Any:
    """The value at ``keys`` in params.yaml, as YAML reads it.

    Raises:
        BelvedereError: the file or one of the keys is missing; names the valid keys.
    """
    if not path.is_file():
        raise BelvedereError(f"{path} is missing; run the stage from the repository root.")
    node: Any = _tree(path, path.stat().st_mtime_ns)
    for depth, key in enumerate(keys):
        if not isinstance(node, dict) or key not in node:
            where = ".".join(keys[:depth]) or "the top level"
            names = node if isinstance(node, dict) else ()
            raise unknown(f"in {path}, under {where}: key", key, names)
        node = node[key]
    return node


def section(model: type[SectionT], *keys: str, path: Path = PARAMS_FILE) -> SectionT:
    """The section at ``keys`` in params.yaml, validated.

    Args:
        model: the section's type.
        keys: its place, such as ``("budgets", "quick", "vae")``.
        path: the parameter file.

    Raises:
        BelvedereError: a key is missing, unknown, of a wrong type or out of range.
    """
    where = ".".join(keys)
    try:
        return model.model_validate(value(*keys, path=path))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join([where, *(str(part) for part in first["loc"])])
        raise BelvedereError(f"{path}: {place} = {first['input']!r} is not valid: {first['msg']}.") from None


def budget_section(model: type[SectionT], noun: str, path: Path = PARAMS_FILE) -> SectionT:
    """The sizes of ``noun`` (a stage) in the chosen budget."""
    name = value("budget", path=path)
    budgets = value("budgets", path=path)
    if name not in budgets:
        raise unknown(f"budget (in {path})", name, budgets)
    return section(model, "budgets", name, noun, path=path)


def repeats(path: Path = PARAMS_FILE) -> int:
    """The number of independent trainings of each branch in the chosen budget."""
    name = value("budget", path=path)
    count = value("budgets", path=path).get(name, {}).get("repeats")
    if not isinstance(count, int) or isinstance(count, bool) or count < 1:
        raise BelvedereError(
            f"{path}: budgets.{name}.repeats = {count!r} is not valid; it is a whole number from 1 up."
        )
    return count


def first_repeats(path: Path = PARAMS_FILE) -> int:
    """How many repeats of every branch are trained before one may be left out; scores' unit is theirs."""
    name = value("budget", path=path)
    count = value("budgets", name, "race", "first", path=path)
    if not isinstance(count, int) or isinstance(count, bool) or count < 1:
        raise BelvedereError(
            f"{path}: budgets.{name}.race.first = {count!r} is not valid; it is a whole number from 1 up."
        )
    return count


def seed(path: Path = PARAMS_FILE) -> int:
    """The root of every random draw."""
    root = value("seed", path=path)
    if not isinstance(root, int) or isinstance(root, bool) or root < 0:
        raise BelvedereError(f"{path}: seed = {root!r} is not valid; it is a whole number from 0 up.")
    return root


def heldout_share(path: Path = PARAMS_FILE) -> float:
    """The share of a repeat's episodes on which no network is trained."""
    share = value("heldout_share", path=path)
    if not isinstance(share, (int, float)) or isinstance(share, bool) or not 0 < share < 1:
        raise BelvedereError(
            f"{path}: heldout_share = {share!r} is not valid; it lies strictly between 0 and 1."
        )
    return float(share)
