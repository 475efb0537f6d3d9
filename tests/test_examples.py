"""What `examples/` shows works on the committed results."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tests.support import ROOT

RANKINGS = sorted((ROOT / "reports/rankings").glob("*.json"))


@pytest.mark.parametrize("file", RANKINGS, ids=lambda file: file.stem)
def test_a_ranking_is_read_in_a_few_lines(file) -> None:
    command = [sys.executable, "examples/read_ranking.py", file.stem]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    ranking = json.loads(file.read_text(encoding="utf-8"))
    assert told[0] == ranking["answer"]["sentence"]
    assert [line.split(":")[0] for line in told[1:]] == list(ranking["viewpoints"])
