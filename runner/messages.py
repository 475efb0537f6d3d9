"""What a run of the study says before and after."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipeline.contract import params
from runner.rankings import read_ranking


def announcement(scenes: Sequence[str]) -> str:
    """What is about to be done, at which scale; no scene stands for all."""
    asked = scenes or list(params.value("scenes"))
    views = [params.value("viewpoint"), *params.value("viewpoints").values()]
    count = sum(view["scene"] in asked for view in views)
    budget = params.budget()
    return (
        f"Comparing {count} viewpoints in {len(asked)} scene(s) at budget {budget!r}: "
        f"{params.value('budgets', budget, 'about')}\n"
        "Only what changed is computed, and a run that was stopped continues.\n"
    )


def answers() -> str:
    """Each scene's answer, and where the report lies."""
    lines = [f"{scene}: {read_ranking(scene).answer.sentence}" for scene in params.value("scenes")]
    return "\n".join(["", *lines, "", f"Report: {Path('reports/index.html').resolve()}"])
