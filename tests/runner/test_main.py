"""What `./run --jobs` takes and passes on."""

from __future__ import annotations

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import CORES_VARIABLE, cores
from runner.__main__ import THREADS_VARIABLE, number_of_jobs, shares
from tests.support import Clone


@pytest.mark.parametrize("given", ["0", "-1", "two", "1.5", "", "²", " 2"])
def test_a_number_of_jobs_that_is_none_is_refused(given: str) -> None:
    with pytest.raises(BelvedereError, match="whole number from 1 up"):
        number_of_jobs(given)


@pytest.mark.parametrize("arguments", [["--jobs", "two"], ["--jobs=0"], ["--jobs"]])
def test_the_front_door_says_so_in_one_sentence(clone: Clone, arguments: list[str]) -> None:
    clone.lend_environment()
    done = clone.run("./run", *arguments, status=1)
    assert done.stdout == "" and len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("error: --jobs ")


@pytest.mark.parametrize("slots", [1, 2, 3, 1000])
def test_together_the_processes_use_the_cores_that_there_are(
    monkeypatch: pytest.MonkeyPatch, slots: int
) -> None:
    monkeypatch.delenv(CORES_VARIABLE, raising=False)
    share = int(shares(slots, {})[CORES_VARIABLE])
    assert share >= 1
    assert share * slots <= cores() < (share + 1) * slots or share == 1


def test_what_the_user_set_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CORES_VARIABLE, "7")
    given = {CORES_VARIABLE: "7", THREADS_VARIABLE: "3", "OTHER": "x"}
    assert shares(2, given) == given
    assert shares(2, {CORES_VARIABLE: "7"})[THREADS_VARIABLE] == "7"
