"""Ways in which files get damaged."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from typing import Any

import numpy as np

CHECKED = (".pt", ".npz")  # what carries checksums; numbers as text and pictures carry none
_ENTRIES = 4  # below a JSON file's top level that lose their value


def flipped(content: bytes, bit: int) -> bytes:
    """The same bytes with one bit turned."""
    turned = bytearray(content)
    turned[bit // 8] ^= 1 << bit % 8
    return bytes(turned)


def foreign(content: bytes) -> dict[str, bytes]:
    """What a file may hold instead of its content, whatever kind it is of."""
    half = content[: len(content) // 2]
    junk = np.random.default_rng(1).bytes(100)
    return {
        "empty": b"",
        "half": half,
        "junk": junk,
        "object": b"{}",
        "null": b"null",
        "Latin-1": b"\xe9t\xe9",
    }


def flips(content: bytes, count: int) -> dict[str, bytes]:
    """So many single flipped bits, anywhere."""
    bits = np.random.default_rng(len(content)).integers(0, 8 * len(content), count)
    return {f"bit {bit} flipped": flipped(content, int(bit)) for bit in bits}


def lacking(content: bytes) -> dict[str, bytes]:
    """A JSON file with an entry null, or without it: those of its top level, and some below."""
    tree = json.loads(content)
    top, deeper = ([p for p in _places(tree) if (len(p) == 1) is is_top] for is_top in (True, False))
    picked = np.random.default_rng(len(content)).permutation(len(deeper))[:_ENTRIES]
    found = {}
    for place in [*top, *(deeper[i] for i in picked)]:
        for what in ("null", "missing"):
            changed = copy.deepcopy(tree)
            *above, last = place
            holder = changed
            for key in above:
                holder = holder[key]
            if what == "null":
                holder[last] = None
            else:
                del holder[last]
            found[f"{'.'.join(map(str, place))} {what}"] = json.dumps(changed).encode()
    return found


def _places(node: Any, above: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    pairs = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in pairs:
        yield (*above, key)
        yield from _places(value, (*above, key))
