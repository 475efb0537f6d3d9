"""What a run of the study says before and after."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipeline.contract import params
from pipeline.contract.artefacts import read_json

RANKINGS = Path("reports/rankings")


def announcement(scenes: Sequence[str]) -> str:
    """What is about to be done, at which scale; no scene stands for all."""
    asked = scenes or list(params.value("scenes"))
    views = [params.value("viewpoint"), *params.value("viewpoints").values()]
    count = sum(view["scene"] in asked for view in views)
    budget = params.budget()
    return (
        f"Comparing {count} viewpoints in {len(asked)} scene(s) at budget {budget!r}: "
        f"{params.value('budgets', budget, 'about')}\n"
        "What is done already is not done again, and a run that was stopped goes on where it was.\n"
    )


def answers() -> str:
    """Each scene's answer, and where the report lies."""
    found = {scene: RANKINGS / f"{scene}.json" for scene in params.value("scenes")}
    told = {s: read_json(path, f"ranking@{s}")["answer"]["sentence"] for s, path in found.items()}
    lines = [f"{scene}: {sentence}" for scene, sentence in told.items()]
    return "\n".join(["", *lines, "", f"Report: {Path('reports/index.html').resolve()}"])
