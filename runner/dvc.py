"""`python -m runner.dvc …` is `dvc …` that checks params.yaml first, and loses less time on YAML and starts.

For every stage DVC parses params.yaml again, and for every stage that ran dvc.lock, which it then writes
whole, in pure Python: with some hundred stages that takes longer than some stages do. Here libyaml parses
what is only read, and dvc.lock, in which there are no comments to keep, as DVC writes it alone. Of dvc.lock
only what changed is written again (:mod:`runner.lock`), and half of it is never there. The stages of
branches are forked from one process (:mod:`runner.warm`). What comes out is the same as by `dvc`, but that
with --allow-missing what a changed stage reads is made (:mod:`runner.missing`).
"""

from __future__ import annotations

import os
import pickle
import shlex
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from pipeline.contract.errors import BelvedereError
from pipeline.contract.yamls import parse
from runner.lock import LOCK_FILE, check_lock, updated
from runner.missing import make_missing, refuse_missing_in_queue
from runner.parameters import check_parameters
from runner.rwlock import drop_damaged_rwlock
from runner.warm import STAGES, Warm


@lru_cache(maxsize=8)
def _parsed(text: str) -> bytes:
    """What a text holds, pickled: DVC parses dvc.lock again for each target, and may change what it gets."""
    return pickle.dumps(parse(text) or {})


def read_faster() -> None:
    """Makes DVC, in this process, parse by libyaml where no comments have to be kept."""
    from dvc.utils import serialize, strictyaml
    from dvc.utils.serialize import _yaml

    slow = _yaml.parse_yaml

    def parse_yaml(text: str, path: Any, typ: str = "safe") -> Any:
        if typ != "safe" and not str(path).endswith(LOCK_FILE.name):
            return slow(text, path, typ)
        try:
            return pickle.loads(_parsed(text))  # noqa: S301 - this process made it
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
        if file.name != LOCK_FILE.name or not file.is_file():
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
        former = signal.signal(signal.SIGINT, signal.SIG_IGN)  # the stage handles Ctrl-C, as DVC has it
        try:
            status = warm.run(words[2], words[3:], str(how["cwd"]), how["env"])
        finally:
            signal.signal(signal.SIGINT, former)
        if status:
            raise StageCmdFailedError(command, status)

    run._run = run_command


def check_first() -> None:
    """Makes DVC, in this process, look at params.yaml before it runs anything."""
    from dvc.exceptions import DvcException
    from dvc.repo import Repo

    unchecked = Repo.reproduce

    def reproduce(repo: Repo, *how: Any, **more: Any) -> Any:
        try:
            check_parameters()
            check_lock()
        except BelvedereError as error:
            raise DvcException(str(error)) from None
        return unchecked(repo, *how, **more)

    Repo.reproduce = reproduce


def main(arguments: list[str]) -> int:
    """Runs DVC's command line and returns its status."""
    from dvc.cli import main as command

    check_first()
    drop_damaged_rwlock()
    read_faster()
    write_faster()
    start_faster()
    make_missing()
    refuse_missing_in_queue()
    return int(command(arguments))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
