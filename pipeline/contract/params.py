"""Reading params.yaml, section by section.

Each section's model lives beside its consumer and derives from :class:`Section`; this module only
knows how to read one and how to say, in a sentence, what is wrong with it.
"""

from __future__ import annotations

import json
import reprlib
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from pipeline.contract.errors import BelvedereError, unknown
from pipeline.contract.yamls import read_yaml

PARAMS_FILE = Path("params.yaml")
MOST_REPEATS = 40  # of a viewpoint


class Section(BaseModel):
    """A frozen section of params.yaml: unknown keys and wrong types are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


SectionT = TypeVar("SectionT", bound=Section)


@lru_cache(maxsize=4)
def _tree(path: Path, mtime_ns: int) -> dict[str, Any]:
    tree = read_yaml(path)
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
    return _validated(model, ".".join(keys), value(*keys, path=path), path)


def _validated(model: type[SectionT], where: str, tree: Any, path: Path) -> SectionT:
    try:  # as JSON, by pydantic's strict rules: lists are tuples, but 1 is not true and "1" is not 1
        return model.model_validate_json(json.dumps(tree, default=str), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join([*filter(None, [where]), *(str(part) for part in first["loc"])])
        raise invalid(path, place, first["input"], first["msg"].removeprefix("Value error, ")) from None


def invalid(path: Path, place: str, given: object, why: str) -> BelvedereError:
    """The error for a value of params.yaml; a whole section is not printed, and a long text only in part."""
    shown = "" if isinstance(given, (dict, list)) else f" = {reprlib.repr(given)}"
    return BelvedereError(f"{path}: {place}{shown} is not valid: {why}.")


def budget_section(
    model: type[SectionT], noun: str, scene: str | None = None, path: Path = PARAMS_FILE
) -> SectionT:
    """The sizes of ``noun`` (a stage) in the chosen budget.

    Args:
        model: the section's type.
        noun: the stage.
        scene: where the section has an entry ``scenes`` with an entry of this name, its values count
            before the section's own.
        path: the parameter file.
    """
    return _with_scene(model, ("budgets", budget(path), noun), scene, path)


def scene_section(model: type[SectionT], *keys: str, scene: str, path: Path = PARAMS_FILE) -> SectionT:
    """The section at ``keys``, whose entry ``scenes`` may have other values for ``scene``."""
    return _with_scene(model, keys, scene, path)


def _with_scene(model: type[SectionT], keys: tuple[str, ...], scene: str | None, path: Path) -> SectionT:
    tree, where = value(*keys, path=path), ".".join(keys)
    if not isinstance(tree, dict) or "scenes" not in tree:
        return section(model, *keys, path=path)
    own = {key: entry for key, entry in tree.items() if key != "scenes"}
    named = mapping(*keys, "scenes", path=path)
    others = mapping(*keys, "scenes", scene, path=path) if scene in named else {}
    return _validated(model, where, own | others, path)


def mapping(*keys: str, path: Path = PARAMS_FILE) -> dict[str, Any]:
    """The mapping at ``keys``; an empty one where nothing stands after the key."""
    tree = value(*keys, path=path)
    if tree is not None and not isinstance(tree, dict):
        raise invalid(path, ".".join(keys), tree, "it is a mapping of names to values")
    return tree or {}


def budget(path: Path = PARAMS_FILE) -> str:
    """The name of the chosen budget."""
    name, budgets = value("budget", path=path), mapping("budgets", path=path)
    if not isinstance(name, str) or name not in budgets:
        raise unknown(f"budget (in {path})", name, budgets)
    return name


class Race(Section):
    """Section ``budgets.*.race``: how many repeats (independent trainings) a viewpoint of a scene gets.

    Attributes:
        first: of every viewpoint, before any comparison.
        most: of the viewpoints that stay in the race to its end.
    """

    first: Annotated[int, Field(ge=2)]
    most: Annotated[int, Field(le=MOST_REPEATS)]

    @model_validator(mode="after")
    def _ordered(self) -> Race:
        if self.most < self.first:
            raise ValueError(f"most ({self.most}) must not be less than first ({self.first})")
        return self


def race(scene: str, path: Path = PARAMS_FILE) -> Race:
    """How many repeats the scene's viewpoints get in the chosen budget."""
    return budget_section(Race, "race", scene, path)


def first_repeats(scene: str, path: Path = PARAMS_FILE) -> int:
    """How many repeats every viewpoint of the scene has before any comparison."""
    return race(scene, path).first


def seed(path: Path = PARAMS_FILE) -> int:
    """The root of every random draw."""
    root = value("seed", path=path)
    if not isinstance(root, int) or isinstance(root, bool) or not 0 <= root < 2**63:
        raise invalid(path, "seed", root, "it is a whole number from 0 up, below 2⁶³")
    return root


def heldout_share(path: Path = PARAMS_FILE) -> float:
    """The share of a repeat's episodes on which no network is trained."""
    return _share("heldout_share", path)


def sight_share(path: Path = PARAMS_FILE) -> float:
    """Where a probe of tip - target errs by more than this share of a guess's error, the judge cannot see."""
    return _share("sight_share", path)


def _share(name: str, path: Path) -> float:
    share = value(name, path=path)
    if not isinstance(share, (int, float)) or isinstance(share, bool) or not 0 < share < 1:
        raise invalid(path, name, share, "it lies strictly between 0 and 1")
    return float(share)
