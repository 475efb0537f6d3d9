"""Reading YAML as DVC does: the scalars of YAML 1.2, where ``030`` is thirty and ``1e-3`` a number.

PyYAML's own rules are those of YAML 1.1 (24, and text), and of a key that stands twice it takes the last.
"""

from __future__ import annotations

import re
from collections.abc import Hashable
from pathlib import Path
from typing import Any

import yaml

from pipeline.contract.errors import BelvedereError

_NUMBERS = list("-+.0123456789")
_SCALARS = (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9][0-9_]*|0o[0-7]+|0x[0-9a-fA-F]+", _NUMBERS),
    ("float", r"[-+]?(\.[0-9]+|[0-9][0-9_]*(\.[0-9_]*)?)([eE][-+]?[0-9]+)?", _NUMBERS),
    ("float", r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", _NUMBERS),
    ("merge", r"<<", ["<"]),
)


class Loader(yaml.CSafeLoader):
    """libyaml's parser with the scalars of YAML 1.2; a key that stands twice is an error."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012  (PyYAML's own attribute)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """The mapping, if each of its own keys stands in it once."""
        seen = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode) and (key.tag, key.value) in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {key.value!r} stands twice in one mapping", key.start_mark
                )
            seen.add((key.tag, key.value) if isinstance(key, yaml.ScalarNode) else id(key))
        return super().construct_mapping(node, deep)


def _integer(loader: Loader, node: yaml.ScalarNode) -> int:
    return int(node.value, 0) if node.value[:2] in ("0o", "0x") else int(node.value)


for _tag, _pattern, _first in _SCALARS:
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_pattern})$"), _first)
Loader.add_constructor("tag:yaml.org,2002:int", _integer)


def parse(text: str) -> Any:
    """What a text holds.

    Raises:
        yaml.YAMLError: it is no YAML, has a key twice in one mapping, or makes other than plain values.
    """
    try:
        return yaml.load(text, Loader)
    except (RecursionError, ValueError) as error:  # ValueError: an integer of too many digits
        raise yaml.YAMLError(str(error)) from None


def read_yaml(path: Path) -> Any:
    """What a file holds.

    Raises:
        FileNotFoundError: there is no such file.
        BelvedereError: it is no UTF-8 text or no YAML.
    """
    try:
        return parse(path.read_text(encoding="utf-8"))
    except UnicodeDecodeError as error:
        byte = error.object[error.start]
        raise BelvedereError(
            f"{path} is not UTF-8 text (byte {error.start} is {byte:#04x}); save it as UTF-8."
        ) from None
    except yaml.YAMLError as error:
        raise BelvedereError(f"{path} is not valid YAML: {' '.join(str(error).split())}.") from None
