"""What the pipeline's source says of itself: which files a stage imports, and a hash of them."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_PACKAGE = "pipeline"


@cache
def tree(file: str) -> ast.Module:
    """A file's syntax tree; ``file`` is a path from the repository's root."""
    return ast.parse((ROOT / file).read_text(encoding="utf-8"))


def file_of(module: str) -> str | None:
    """The file of a dotted module, as a path from the root, or None where there is no such module."""
    stem = module.replace(".", "/")
    return next((f for f in (f"{stem}.py", f"{stem}/__init__.py") if (ROOT / f).is_file()), None)


@cache
def imported_names(file: str) -> dict[str, str]:
    """Local names that a file's imports bind to something of ``pipeline``, and its dotted name."""
    bound: dict[str, str] = {}
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == _PACKAGE:
            bound |= {a.asname or a.name: f"{node.module}.{a.name}" for a in node.names}
        if isinstance(node, ast.Import):
            bound |= {a.asname or a.name: a.name for a in node.names if a.name.startswith(f"{_PACKAGE}.")}
    return bound


@cache
def modules_behind(file: str) -> frozenset[str]:
    """``file`` and every file of ``pipeline`` that importing it imports, as paths from the root."""
    found: set[str] = set()
    waiting = [file]
    while waiting:
        at = waiting.pop()
        if at not in found:
            found.add(at)
            waiting += [f for target in imported_names(at).values() for f in _packages(target)]
    return frozenset(found)


def code_digest(stage: str) -> str:
    """A hash of a stage's script and of all that it imports of the pipeline, wherever the tree lies.

    Args:
        stage: the stage's name, such as ``"vae"``.
    """
    hasher = hashlib.sha256()
    for file in sorted(modules_behind(f"{_PACKAGE}/{stage}.py")):
        hasher.update(file.encode() + b"\0" + (ROOT / file).read_bytes() + b"\0")
    return hasher.hexdigest()


def _packages(module: str) -> Iterator[str]:
    """The module's file and those of the packages that hold it: importing one runs them all."""
    parts = module.split(".")
    for depth in range(1, len(parts) + 1):
        if file := file_of(".".join(parts[:depth])):
            yield file
