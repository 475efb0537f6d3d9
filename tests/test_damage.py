"""Damaged files, a campaign: every file that a stage reads by dvc.yaml, in every way of tests/damage.py.

What is damaged as a whole is told, or changes nothing. What lacks an entry is told or skipped, since some
entries may be null. A stage that ends with an error says one sentence and leaves its outputs as they were.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pipeline.storage import stage
from tests.chain import IN_ORDER, Step, files_below, steps, write_inputs
from tests.damage import CHECKED, flips, foreign, lacking

NO_ARTEFACT = ("scene", "rollouts", "anchors", "operator", "dqn")
READING = [name for name in IN_ORDER if name not in NO_ARTEFACT]
AT_LENGTH = ("frames", "vae", "controller", "report")  # which take longest where damage changes nothing
PICTURES = (".png", ".webp")


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The working directory, with a study taken through all stages."""
    folder = tmp_path_factory.mktemp("study")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("BELVEDERE_SCRATCH", str(folder / "scratch"))
        patch.setenv("BELVEDERE_CORES", "1")
        patch.setenv("BELVEDERE_DEVICE", "cpu")
        patch.setattr(
            stage, "_others_work", lambda _: False
        )  # or a stage that fails ends this process at once
        write_inputs(folder)
        for step in (step for name in IN_ORDER for step in steps(name)):
            step.run()
        yield folder


def damaged(file: Path, turn: int) -> dict[str, bytes | None]:
    """What becomes of a file, by name; None is its absence.

    A store's files, weights and pictures take a few ways each, in turn: a stage does its whole work where
    it does not read the damaged part.
    """
    content = file.read_bytes()
    ways = list(foreign(content).items())
    in_store = any(part.endswith(".zarr") for part in file.parts)
    if in_store or file.suffix in (*CHECKED, *PICTURES):
        ways = [ways[turn % len(ways)], ways[(turn + 2) % len(ways)]]
    if in_store or file.suffix in CHECKED:
        ways += flips(content, 1).items()
    entries = lacking(content) if file.suffix == ".json" and not in_store else {}
    return {"missing": None, **dict(ways), **entries}


def put(file: Path, content: bytes | None) -> None:
    """Puts ``content`` in the place of a file, whose bytes the scratch store may share."""
    file.unlink(missing_ok=True)
    if content is not None:
        file.write_bytes(content)


def held_to_the_law(step: Step, told_or_same: bool, capfd: pytest.CaptureFixture[str]) -> str | None:
    """What is wrong with how a stage takes its damaged input, if something is."""
    before = {out: out.read_bytes() for out in files_below(step.outs)}
    capfd.readouterr()
    status = 0
    try:
        step.run()
    except SystemExit as end:
        status = int(str(end.code))
    except BaseException as error:
        return f"ends with {type(error).__name__}: {error}"
    same = {out: out.read_bytes() for out in files_below(step.outs)} == before
    if status == 0:
        if same or not told_or_same:
            return None
        return "is taken for good"
    sentences = [line for line in capfd.readouterr().err.splitlines() if line.startswith("error: ")]
    if len(sentences) != 1:
        return f"is told in {len(sentences)} sentences"
    return None if same else "is told after an output was written"


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in AT_LENGTH else n for n in READING]
)
def test_damaged_files_are_told_or_change_nothing(
    name: str, study: Path, capfd: pytest.CaptureFixture[str], record_property: Callable[[str, object], None]
) -> None:
    step = steps(name)[-1]
    outs = {out: out.read_bytes() for out in files_below(step.outs)}
    tried, wrong = 0, []
    for turn, file in enumerate(step.files):
        if "repeat_0.zarr" in file.parts:  # as repeat 1
            continue
        good = file.read_bytes()
        for way, content in damaged(file, turn).items():
            put(file, content)
            whole = way in foreign(b"") or "flipped" in way
            found = held_to_the_law(step, whole, capfd)
            wrong += [f"{file}, {way}: {found}"] if found else []
            tried += 1
            for out, former in outs.items():
                put(out, former)
        put(file, good)
    with capfd.disabled():
        print(f" {name}: {tried} cases", end="", flush=True)
    record_property("cases", tried)
    assert wrong == []
    assert tried >= 5 * len(step.deps)
