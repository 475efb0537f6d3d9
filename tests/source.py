"""Which parameters a script reads, by its source."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pipeline.contract.source import file_of, imported_names, tree

READERS = "pipeline.contract.params"


def params_read_by(file: str) -> set[str]:
    """Keys of params.yaml that a script reads, itself or in what it refers to in its imports.

    Followed are names of functions, classes and modules, so a key may be found that is never read in
    fact. A part of a key that is no literal is ``*``, and a key that begins with one is skipped; the
    chosen budget is ``${budget}``.
    """
    keys: set[str] = set()
    seen: set[tuple[str, str]] = set()
    waiting = [(file, "")]
    while waiting:
        place = waiting.pop()
        if place in seen or _dotted(place[0]) == READERS:
            continue
        seen.add(place)
        for node in _nodes(*place):
            read = _keys_read(place[0], node) if isinstance(node, ast.Call) else []
            keys.update(key for key in read if key and not key.startswith("*"))
            waiting += _referred(place[0], node)
    return keys


def _dotted(file: str) -> str:
    return file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def _nodes(file: str, name: str) -> Iterator[ast.AST]:
    """All of the file, or the definition of ``name`` in it and what stands outside definitions."""
    for statement in tree(file).body:
        defined = getattr(statement, "name", None)
        if not name or defined in (None, name):
            yield from ast.walk(statement)


def _target(file: str, node: ast.AST) -> str | None:
    """The dotted name of what an expression refers to, where that is of ``pipeline``."""
    if isinstance(node, ast.Name):
        own = {getattr(s, "name", None) for s in tree(file).body}
        return f"{_dotted(file)}.{node.id}" if node.id in own else imported_names(file).get(node.id)
    if isinstance(node, ast.Attribute) and (base := _target(file, node.value)):
        return f"{base}.{node.attr}"
    return None


def _referred(file: str, node: ast.AST) -> list[tuple[str, str]]:
    module, _, name = (_target(file, node) or "").rpartition(".")
    found = file_of(module) if module else None
    return [(found, name)] if found else []


def _keys_read(file: str, call: ast.Call) -> list[str]:
    module, _, reader = (_target(file, call.func) or "").rpartition(".")
    if module != READERS:
        return []
    words = [a.value if isinstance(a, ast.Constant) else "*" for a in call.args]
    match reader:
        case "value":
            return [".".join(words)]
        case "section" | "scene_section":
            return [".".join(words[1:])]
        case "budget_section":
            return [f"budgets.${{budget}}.{words[1]}"]
        case "race":
            return ["budgets.${budget}.race"]
        case "first_repeats":
            return ["budgets.${budget}.race.first", "budgets.${budget}.race.scenes"]
        case "budget":
            return ["budget"]
        case "seed" | "heldout_share" | "sight_share":
            return [reader]
    return []
