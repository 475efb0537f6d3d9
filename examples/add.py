"""`./run python examples/add.py FILE…`: puts the entries of example files into params.yaml."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from pipeline.checks.parameters import check
from pipeline.contract.errors import BelvedereError
from pipeline.contract.params import PARAMS_FILE
from pipeline.contract.stage import entry
from pipeline.contract.yamls import read_yaml


def added(params: str, example: str, path: Path = PARAMS_FILE) -> str:
    """The text of params.yaml with an example's entries below ``robots:``, ``scenes:`` and so on.

    Raises:
        BelvedereError: params.yaml has no such key.
    """
    for block in re.split(r"(?m)^(?=\w+:)", example)[1:]:
        key, _, entries = block.partition("\n")
        where = re.search(rf"(?m)^{key}.*\n", params)
        if where is None:
            raise BelvedereError(f"{path} has no key {key.rstrip(':')} below which an example could stand.")
        params = params[: where.end()] + entries.strip("\n") + "\n" + params[where.end() :]
    return params


def main(*, files: list[Path]) -> None:
    """Adds each file's entries, if params.yaml is valid with them."""
    former = PARAMS_FILE.read_text(encoding="utf-8")
    for file in files:
        read_yaml(file)
        text = added(PARAMS_FILE.read_text(encoding="utf-8"), file.read_text(encoding="utf-8"))
        PARAMS_FILE.write_text(text, encoding="utf-8")
    try:
        check()
    except BelvedereError:
        PARAMS_FILE.write_text(former, encoding="utf-8")
        raise
    print(f"{PARAMS_FILE} has the entries of {', '.join(file.name for file in files)}")


if __name__ == "__main__":
    entry(main, ["--files", *sys.argv[1:]])
