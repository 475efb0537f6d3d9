"""What a run of the whole study says before and after."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml


def announcement() -> str:
    """What is about to be done, at which scale."""
    params = yaml.safe_load(Path("params.yaml").read_text(encoding="utf-8"))
    budget = params["budget"]
    return (
        f"Ranking {len(params['viewpoints']) + 1} viewpoints in {len(params['scenes'])} scenes "
        f"at budget {budget!r}: {params['budgets'][budget]['about']}\n"
        "What is done already is not done again, and a run that was stopped goes on where it was.\n"
    )


def verdicts() -> str:
    """Each scene's answer, what is still open, and where the report lies."""
    rankings = [
        json.loads(file.read_text(encoding="utf-8"))
        for file in sorted(Path("reports/rankings").glob("*.json"))
    ]
    lines = [f"{ranking['scene']}: {_answer(ranking)}" for ranking in rankings]
    return "\n".join(["", *lines, "", f"Report: {Path('reports/index.html').resolve()}"])


def _answer(ranking: Mapping[str, Any]) -> str:
    still_open = " Still open; ./run goes on." if ranking["race"]["open"] else ""
    return f"{ranking['answer']['sentence']}{still_open}"
