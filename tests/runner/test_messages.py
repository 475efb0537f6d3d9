"""What a run says at its end: an answer per scene, and the page."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from pipeline.storage.artefacts import write_json
from runner.messages import announcement, answers

SCENES = ("panda_2dof", "fetch_reach")


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    views = [{"scene": scene, "theta": theta, "phi": 0} for scene in SCENES for theta in (0, 90)]
    tree = {
        "budget": "small",
        "budgets": {"small": {"about": "seconds."}},
        "viewpoint": {"scene": "panda_2dof", "theta": 45, "phi": 0},
        "viewpoints": {str(index): view for index, view in enumerate(views)},
        "scenes": {scene: {} for scene in SCENES},
    }
    (tmp_path / "params.yaml").write_text(yaml.safe_dump(tree, sort_keys=False))
    return tmp_path


def test_it_ends_with_an_answer_per_scene_and_the_page(place: Path) -> None:
    for scene in SCENES:
        answer = {"sentence": f"Put the camera of {scene} there.", "progress": ""}
        race = {"open": False, "common": 3, "active": []}
        content = {"answer": answer, "race": race, "most": 20}
        write_json(place / f"reports/rankings/{scene}.json", content)
    assert answers().split("\n") == [
        "",
        "panda_2dof: Put the camera of panda_2dof there.",
        "fetch_reach: Put the camera of fetch_reach there.",
        "",
        f"Report: {place / 'reports/index.html'}",
    ]


@pytest.mark.parametrize(
    ("scenes", "told"), [([], "5 viewpoints in 2"), (["panda_2dof"], "3 viewpoints in 1")]
)
def test_it_begins_with_what_it_is_about_to_do(scenes: list[str], told: str) -> None:
    assert announcement(scenes).startswith(f"Comparing {told} scene(s) at budget 'small': seconds.")
