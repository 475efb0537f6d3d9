"""`./run python -m examples.add FILE…`: puts the entries of example files into params.yaml and dvc.yaml."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from pipeline.checks.parameters import check
from pipeline.contract.declared import PIPELINE_FILE, check_viewpoints
from pipeline.contract.errors import BelvedereError
from pipeline.contract.params import PARAMS_FILE
from pipeline.contract.yamls import parse, read_yaml
from pipeline.storage.artefacts import writing
from pipeline.storage.stage import entry

STUDY = "      study: ${viewpoint}\n"  # the first line of dvc.yaml's list of branches


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


def with_branches(pipeline: str, example: str) -> str:
    """The text of dvc.yaml with a line for each of an example's viewpoints in the list of branches.

    Raises:
        BelvedereError: dvc.yaml has no such list.
    """
    if pipeline.count(STUDY) != 1:
        raise BelvedereError(
            f"{PIPELINE_FILE} has no one line {STUDY.strip()!r} after which branches could stand."
        )
    lines = [f"      {key}: ${{viewpoints.{key}}}\n" for key in parse(example).get("viewpoints", {})]
    return pipeline.replace(STUDY, STUDY + "".join(lines))


def main(*, files: list[Path]) -> None:
    """Adds each file's entries, if both files are valid with them; else leaves both as they were."""
    former = {file: file.read_text(encoding="utf-8") for file in (PARAMS_FILE, PIPELINE_FILE)}
    try:
        for file in files:
            read_yaml(file)
            example = file.read_text(encoding="utf-8")
            _replace(PARAMS_FILE, added(PARAMS_FILE.read_text(encoding="utf-8"), example))
            _replace(PIPELINE_FILE, with_branches(PIPELINE_FILE.read_text(encoding="utf-8"), example))
        check()
        check_viewpoints()
    except BaseException:
        for path, text in former.items():
            _replace(path, text)
        raise
    print(f"{PARAMS_FILE} and {PIPELINE_FILE} have the entries of {', '.join(file.name for file in files)}")


def _replace(path: Path, text: str) -> None:
    with writing(path) as aside:
        aside.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    entry(main, ["--files", *sys.argv[1:]])
