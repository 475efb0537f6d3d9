"""The text of dvc.lock after some stages changed, made without writing the others' again.

DVC writes the whole file, in pure Python, after every stage that ran: two seconds of each, with some hundred
stages, in which the file is cut short. Here the lines of stages that did not change are copied.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pipeline.contract.errors import BelvedereError
from pipeline.contract.yamls import read_yaml

LOCK_FILE = Path("dvc.lock")
_PARTS = ["schema", "stages"]
_STAGE = re.compile(r"^(?=  \S)", re.MULTILINE)  # what is within a stage is further in


def updated(
    text: str, before: Mapping[str, Any], after: Mapping[str, Any], dumps: Callable[[Any], str]
) -> str:
    """What ``dumps(after)`` gives, of which only the changed stages are passed to ``dumps``.

    Args:
        text: the file's, as ``dumps`` wrote it.
        before: what it holds.
        after: what it shall hold.
        dumps: writes YAML in block style, two spaces for each level.
    """
    if list(before) != _PARTS or list(after) != _PARTS or not after["stages"]:
        return dumps(after)
    head, *lines = _STAGE.split(text)
    if len(lines) != len(before["stages"]) or before["schema"] != after["schema"]:
        return dumps(after)
    old = {
        name: (repr(stage), own) for (name, stage), own in zip(before["stages"].items(), lines, strict=True)
    }
    made = [head]
    for name, stage in after["stages"].items():
        written, own = old.get(name, ("", ""))  # by repr: 1 and 1.0 are equal, and 1 and True
        made.append(own if written == repr(stage) else dumps({"stages": {name: stage}}).partition("\n")[2])
    return "".join(made)


def check_lock(path: Path = LOCK_FILE) -> None:
    """Looks whether dvc.lock is whole: `dvc` that was stopped while it wrote leaves it empty or cut short.

    Raises:
        BelvedereError: it is not; says how to get a whole one.
    """
    from dvc.schema import COMPILED_LOCKFILE_SCHEMA
    from voluptuous import Invalid

    if not path.is_file():
        return
    try:
        COMPILED_LOCKFILE_SCHEMA(read_yaml(path))
    except (BelvedereError, Invalid):
        raise BelvedereError(
            f"{path} is damaged, as by a `dvc` that was stopped while it wrote; `git checkout {path}` brings "
            "back the committed one, and where none is committed it can be deleted; what was made since is "
            "found in DVC's cache, not made again."
        ) from None
