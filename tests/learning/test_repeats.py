"""The store of finished repeats: made once per key, whole or not at all."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from pipeline.learning.repeats import Place, branch_metrics, code_digest, finished, finished_together

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def _scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(tmp_path))


def test_a_repeat_is_made_once_per_key() -> None:
    made = []

    def make(results: Path, running: Path) -> None:
        made.append(running)
        (results / "weights.pt").write_text(str(len(made)))

    first = finished("vae", 0, make, inputs="a")
    assert finished("vae", 0, make, inputs="a") == first
    others = [finished("vae", 1, make, inputs="a"), finished("vae", 0, make, inputs="b")]
    assert [(f / "weights.pt").read_text() for f in (first, *others)] == ["1", "2", "3"]
    assert not made[0].exists()


def test_a_repeat_that_broke_off_finds_its_checkpoint_and_leaves_no_result() -> None:
    def breaks(results: Path, running: Path) -> None:
        (results / "weights.pt").write_text("half")
        (running / "checkpoint").write_text("so far")
        raise KeyboardInterrupt

    def continues(results: Path, running: Path) -> None:
        assert not list(results.iterdir())
        (results / "weights.pt").write_text((running / "checkpoint").read_text())

    with pytest.raises(KeyboardInterrupt):
        finished("vae", 0, breaks, inputs="a")
    assert (finished("vae", 0, continues, inputs="a") / "weights.pt").read_text() == "so far"


def test_only_the_repeats_that_are_missing_are_made_and_together() -> None:
    asked = []

    def make(places: Mapping[int, Place]) -> None:
        asked.append(list(places))
        for repeat, place in places.items():
            (place.results / "weights.pt").write_text(f"{repeat} of {len(places)}")

    (second,) = finished_together("controller", {1: {"inputs": "b"}}, make)
    found = finished_together("controller", {r: {"inputs": name} for r, name in enumerate("abc")}, make)
    assert found[1] == second
    assert [(f / "weights.pt").read_text() for f in found] == ["0 of 2", "1 of 1", "2 of 2"]
    assert (
        finished_together("controller", {r: {"inputs": name} for r, name in enumerate("abc")}, make) == found
    )
    assert asked == [[1], [0, 2]]


def test_code_counts() -> None:
    assert code_digest("learning") != code_digest("learning", "vae.py")
    assert code_digest("learning") == code_digest("learning")


def test_metrics_hold_the_means_over_repeats() -> None:
    attributes = {"scene": "panda_2dof", "theta_deg": 45.0, "phi_deg": 15.0, "format": 1}
    metrics = branch_metrics(attributes, [{"loss": 1.0}, {"loss": 4.0}])
    assert metrics["loss_mean"] == 2.5
    assert [r["repeat"] for r in metrics["repeats"]] == [0, 1]
    assert "format" not in metrics


SLOW_AND = """
import sys, threading, time
from pipeline.contract.errors import BelvedereError
from pipeline.contract.stage import entry
from pipeline.learning.repeats import side_by_side

begun = threading.Event()

def make(repeat):
    if repeat == 0:
        begun.wait()
        if sys.argv[1] == "fails":
            raise BelvedereError("repeat 0 cannot be made")
    print("at work", flush=True)
    begun.set()
    time.sleep(60)

entry(lambda: side_by_side(make, 2), [])
"""


@pytest.mark.usefixtures("heeded_signals")
@pytest.mark.parametrize(("what", "status"), [("fails", 1), ("is interrupted", 130)])
def test_nobody_waits_for_the_other_repeats(what: str, status: int) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW_AND, what],
        cwd=ROOT,
        env=os.environ | {"BELVEDERE_CORES": "2"},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None and process.stdout.readline() == "at work\n"
    if status == 130:
        process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30)
    assert process.returncode == status
    assert said == ("error: repeat 0 cannot be made\n" if status == 1 else "")
