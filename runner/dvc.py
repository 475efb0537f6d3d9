"""`python -m runner.dvc …` is `dvc …` that reads and writes YAML faster and starts a branch's stages faster.

For every stage DVC parses params.yaml anew, and for every stage that ran dvc.lock, which it then writes
whole, in pure Python: with some hundred stages that takes longer than some stages do. Here libyaml parses
what is only read, and dvc.lock, in which there are no comments to keep, as DVC writes it alone. Of dvc.lock
only what changed is written anew (:mod:`runner.lock`), and half of it is never there. The stages of
branches are forked from one process (:mod:`runner.warm`). What comes out is the same as by `dvc`.
"""

from __future__ import annotations

import os
import pickle
import re
import shlex
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from runner.lock import updated
from runner.warm import STAGES, Warm

_LOCK = "dvc.lock"
_NUMBERS = list("-+.0123456789")
# YAML 1.2's plain scalars, as DVC's own parser has them; PyYAML's are those of YAML 1.1.
_SCALARS = (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9][0-9_]*|0o[0-7]+|0x[0-9a-fA-F]+", _NUMBERS),
    ("float", r"[-+]?(\.[0-9]+|[0-9][0-9_]*(\.[0-9_]*)?)([eE][-+]?[0-9]+)?", _NUMBERS),
    ("float", r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", _NUMBERS),
    ("merge", r"<<", ["<"]),
)


class Loader(yaml.CSafeLoader):
    """libyaml's parser with the scalars of YAML 1.2."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012  (PyYAML's own attribute)


def _integer(loader: Loader, node: yaml.ScalarNode) -> int:
    """``030`` is thirty here, and 24 in YAML 1.1."""
    return int(node.value, 0) if node.value[:2] in ("0o", "0x") else int(node.value)


for _tag, _pattern, _first in _SCALARS:
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_pattern})$"), _first)
Loader.add_constructor("tag:yaml.org,2002:int", _integer)


@lru_cache(maxsize=8)
def _parsed(text: str) -> bytes:
    """What a text holds, pickled: DVC parses dvc.lock anew for each target, and may change what it gets."""
    return pickle.dumps(yaml.load(text, Loader) or {})


def read_faster() -> None:
    """Makes DVC, in this process, parse by libyaml where no comments have to be kept."""
    from dvc.utils import serialize, strictyaml
    from dvc.utils.serialize import _yaml

    slow = _yaml.parse_yaml

    def parse_yaml(text: str, path: Any, typ: str = "safe") -> Any:
        if typ != "safe" and not str(path).endswith(_LOCK):
            return slow(text, path, typ)
        try:
            return pickle.loads(_parsed(text))
        except yaml.YAMLError:
            return slow(text, path, typ)  # which tells what is wrong in DVC's own words

    for module in (_yaml, serialize, strictyaml):  # each has the function under its own name
        module.parse_yaml = parse_yaml


def write_faster() -> None:
    """Makes DVC, in this process, write of dvc.lock what changed, aside, and then put it in place."""
    from dvc.utils.serialize import _yaml

    slow = _yaml._modify_data

    @contextmanager
    def modify(path: Any, *how: Any, **more: Any) -> Iterator[Any]:
        file = Path(path)
        if file.name != _LOCK or not file.is_file():
            with slow(path, *how, **more) as data:
                yield data
            return
        text = file.read_text(encoding="utf-8")
        before, after = (_yaml.parse_yaml(text, path) for _ in range(2))
        yield after
        aside = file.with_name(f".{file.name}.{os.getpid()}.part")
        try:
            aside.write_text(updated(text, before, after, _yaml.dumps_yaml), encoding="utf-8")
            aside.replace(file)
        finally:
            aside.unlink(missing_ok=True)

    _yaml._modify_data = modify


def start_faster() -> None:
    """Makes DVC, in this process, fork the stages of branches from a process that has their libraries."""
    from dvc.stage import run
    from dvc.stage.exceptions import StageCmdFailedError

    slow, warm = run._run, Warm()

    def run_command(executable: str | None, command: str, **how: Any) -> None:
        words = shlex.split(command)
        if words[:2] != ["python", "-m"] or words[2].removeprefix("pipeline.") not in STAGES:
            slow(executable, command, **how)
            return
        former = signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the stage's to heed, as DVC has it
        try:
            status = warm.run(words[2], words[3:], str(how["cwd"]), how["env"])
        finally:
            signal.signal(signal.SIGINT, former)
        if status:
            raise StageCmdFailedError(command, status)

    run._run = run_command


def main(arguments: list[str]) -> int:
    """Runs DVC's command line and returns its status."""
    from dvc.cli import main as command

    read_faster()
    write_faster()
    start_faster()
    return int(command(arguments))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
