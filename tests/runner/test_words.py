"""What a run says at its end: an answer per scene, and the page."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.contract.artefacts import write_json
from runner.words import verdicts


def test_it_ends_with_an_answer_per_scene_and_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for scene, still_open in (("panda_2dof", False), ("fetch_reach", True)):
        answer = {"sentence": f"Put the camera of {scene} there."}
        content = {"scene": scene, "answer": answer, "race": {"open": still_open}}
        write_json(tmp_path / f"reports/rankings/{scene}.json", content)
    assert verdicts().split("\n") == [
        "",
        "fetch_reach: Put the camera of fetch_reach there. Still open; ./run goes on.",
        "panda_2dof: Put the camera of panda_2dof there.",
        "",
        f"Report: {tmp_path / 'reports/index.html'}",
    ]
