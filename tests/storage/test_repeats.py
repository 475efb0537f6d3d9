"""The store of finished repeats: made once per key, whole or not at all."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from pipeline.storage.artefacts import write_json, writing
from pipeline.storage.repeats import Place, branch_metrics, finished, finished_together
from tests.damage import flipped

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


def write_two(results: Path, running: Path) -> None:
    (results / "weights.pt").write_bytes(bytes(range(200)))
    write_json(results / "store" / "metrics.json", {"loss": 1.0})


DAMAGES: dict[str, Callable[[Path], object]] = {
    "missing": Path.unlink,
    "empty": lambda file: file.write_bytes(b""),
    "cut in half": lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2]),
    "junk": lambda file: file.write_bytes(b"junk"),
    "null": lambda file: file.write_bytes(b"null"),
    "an empty object": lambda file: file.write_bytes(b"{}"),
    "a flipped bit": lambda file: file.write_bytes(flipped(file.read_bytes(), 37)),
    "one more beside it": lambda file: file.with_name("another").touch(),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_finished_results_that_are_not_as_they_were_written_are_made_anew(
    damage: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each file that a repeat leaves, its manifest too."""
    folder = finished("vae", 0, write_two, inputs="a")
    whole = {f.relative_to(folder): f.read_bytes() for f in folder.rglob("*") if f.is_file()}
    assert len(whole) == 3
    for name in whole:
        DAMAGES[damage](folder / name)
        assert finished("vae", 0, write_two, inputs="a") == folder
        assert {f.relative_to(folder): f.read_bytes() for f in folder.rglob("*") if f.is_file()} == whole
        assert capsys.readouterr().out.count("the repeat is made again") == 1
    assert finished("vae", 0, write_two, inputs="a") == folder
    assert capsys.readouterr().out == ""


def test_what_a_killed_process_left_is_removed(tmp_path: Path) -> None:
    script = textwrap.dedent("""
        import os, signal, sys
        from pathlib import Path
        from pipeline.storage.artefacts import writing
        from pipeline.storage.repeats import finished

        def make(results, running):
            (results / "weights.pt").write_text("half")
            with writing(Path(sys.argv[1])) as aside:
                aside.write_text("half")
                os.kill(os.getpid(), signal.SIGKILL)

        finished("vae", 0, make, inputs="a")
    """)
    output = tmp_path / "out" / "table.csv"
    done = subprocess.run([sys.executable, "-c", script, str(output)], cwd=ROOT)
    assert done.returncode == -signal.SIGKILL and list(output.parent.iterdir())
    results = finished("vae", 0, write_two, inputs="a")
    with writing(output) as aside:
        aside.write_text("whole")
    assert {path.name for path in results.parent.iterdir()} == {".lock", "results"}
    assert list(output.parent.iterdir()) == [output]


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


def test_metrics_hold_the_means_over_repeats() -> None:
    attributes = {"scene": "panda_2dof", "theta_deg": 45.0, "phi_deg": 15.0, "format": 1}
    metrics = branch_metrics(attributes, [{"loss": 1.0}, {"loss": 4.0}])
    assert metrics["loss_mean"] == 2.5
    assert [r["repeat"] for r in metrics["repeats"]] == [0, 1]
    assert "format" not in metrics


SLOW_AND = """
import pathlib, sys, time
from pipeline.contract.errors import BelvedereError
from pipeline.storage.stage import entry
from pipeline.learning.side_by_side import in_processes, side_by_side

what, how, failing = sys.argv[1:4]
begun = pathlib.Path(sys.argv[4])

def make(repeat):
    if repeat == int(failing):
        while not begun.exists():
            time.sleep(0.02)
        if what == "fails":
            raise BelvedereError(f"repeat {repeat} cannot be made")
        if what == "breaks":
            raise RuntimeError("out of memory")
    print("at work", flush=True)
    begun.touch()
    time.sleep(60)

if __name__ == "__main__":
    entry(lambda: {"threads": side_by_side, "processes": in_processes}[how](make, 2), [])
"""


ENDINGS = {
    "fails": (1, "repeat {} cannot be made"),
    "breaks": (1, "out of memory"),
    "is interrupted": (130, ""),
}


@pytest.mark.usefixtures("handled_signals")
@pytest.mark.parametrize("failing", ["0", "1"])
@pytest.mark.parametrize("how", ["threads", "processes"])
@pytest.mark.parametrize("what", ENDINGS)
def test_nobody_waits_for_the_other_repeats(what: str, how: str, failing: str, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(SLOW_AND, encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, str(script), what, how, failing, str(tmp_path / "begun")],
        cwd=ROOT,
        env=os.environ | {"BELVEDERE_CORES": "2", "PYTHONPATH": str(ROOT)},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    assert process.stdout is not None and process.stdout.readline() == "at work\n"
    if what == "is interrupted":
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, said = process.communicate(timeout=30)  # which also waits for processes that hold the pipes
    status, words = ENDINGS[what]
    assert process.returncode == status
    assert words.format(failing) in said


def test_two_processes_that_want_the_same_repeat_make_it_once(tmp_path: Path) -> None:
    script = textwrap.dedent("""
        import pathlib, sys, time
        from pipeline.storage.repeats import finished

        def make(results, running):
            with open(sys.argv[1], "a") as made:
                made.write("made\\n")
            time.sleep(1)
            (running / "checkpoint").write_text("")
            (results / "weights.pt").write_text("weights")

        print((finished("vae", 0, make, inputs="a") / "weights.pt").read_text())
    """)
    command = [sys.executable, "-c", script, str(tmp_path / "made")]
    both = [subprocess.Popen(command, cwd=ROOT, text=True, stdout=subprocess.PIPE) for _ in range(2)]
    said = [process.communicate(timeout=60)[0] for process in both]
    assert [process.returncode for process in both] == [0, 0]
    assert all(text.endswith("weights\n") for text in said)
    assert sum("waiting for another process" in text for text in said) == 1
    assert (tmp_path / "made").read_text() == "made\n"
