"""A stage's entry: flags from the signature, one sentence and status 1 for bad input."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from pipeline.contract.errors import BelvedereError, unknown
from pipeline.storage.stage import WORKER, entry, parser

FLAGS = ["--scene", "panda_2dof", "--theta", "-45", "--out", "a folder/b"]


def stage(
    *, scene: str, theta: float, out: Path, keys: list[str] | None = None, depth_m: float = 0.5
) -> None:
    """Stands in for a stage's main."""


def test_flags_are_the_parameters_with_their_types() -> None:
    given = vars(parser(stage).parse_args([*FLAGS, "--depth-m", "2"]))
    assert given == {
        "scene": "panda_2dof",
        "theta": -45.0,
        "out": Path("a folder/b"),
        "keys": None,
        "depth_m": 2.0,
    }


def test_a_small_negative_angle_is_a_number() -> None:
    given = parser(stage).parse_args(["--scene", "s", "--theta=-1e-05", "--out", "o"])
    assert given.theta == -1e-05


def test_main_is_called_with_what_was_given() -> None:
    called = {}

    def main(*, scene: str, theta: float, out: list[Path]) -> None:
        called.update(scene=scene, theta=theta, out=out)

    entry(main, ["--scene", "s", "--theta", "1e1", "--out", "a", "b"])
    assert called == {"scene": "s", "theta": 10.0, "out": [Path("a"), Path("b")]}


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (FLAGS[:4], "--out"),
        ([*FLAGS, "--colour", "red"], "--colour"),
        (["--scene", "s", "--theta", "steep", "--out", "o"], "'steep'"),
        (["--scene", "s", "--theta", "-1e-05", "--out", "o"], "--theta"),  # dvc.yaml has --theta=-1e-05
    ],
)
def test_wrong_flags_are_refused(argv: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        entry(stage, argv)
    said = capsys.readouterr().err
    assert end.value.code == 1
    assert told in said and said.startswith("error: ") and said.count("\n") == 1


def test_bad_input_ends_with_one_sentence_and_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    def main() -> None:
        raise unknown("viewpoint", "fron", ["front", "side"])

    with pytest.raises(SystemExit) as end:
        entry(main, [])
    assert end.value.code == 1
    told = capsys.readouterr().err
    assert told == "error: viewpoint 'fron' is unknown; available: front, side.\n"


def test_workers_of_others_do_not_end_the_process_at_once() -> None:
    """In a process that runs one stage after the other, workers of an earlier one may be alive."""

    def main() -> None:
        raise unknown("viewpoint", "fron", ["front"])

    done = threading.Event()
    with ThreadPoolExecutor(1, WORKER) as pool:
        pool.submit(done.wait)
        with pytest.raises(SystemExit) as end:
            entry(main, [])
        done.set()
    assert end.value.code == 1


def test_a_defect_keeps_its_traceback() -> None:
    def main() -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        entry(main, [])


def test_an_interrupt_ends_with_the_shells_status() -> None:
    def main() -> None:
        raise KeyboardInterrupt

    with pytest.raises(SystemExit) as end:
        entry(main, [])
    assert end.value.code == 130


def test_an_empty_list_of_names_is_told() -> None:
    assert "available: none" in str(unknown("scene", "x", []))
    assert isinstance(unknown("scene", "x", []), BelvedereError)


def test_a_stage_that_is_done_does_not_fail_where_its_seconds_cannot_be_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "seconds").write_text("a file where the records' folder would be")
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(tmp_path))
    monkeypatch.setenv("DVC_STAGE", "frames@study")
    entry(stage, ["--scene", "s", "--theta", "0", "--out", "o"])
    assert "warning: the seconds of frames@study are not recorded" in capsys.readouterr().err
