"""The schedule, with a program `dvc` that writes down its calls and does as its stage's name says."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import psutil
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import CORES_VARIABLE
from runner import schedule
from runner.plan import Job
from runner.schedule import Schedule

# As DVC does, it leaves SIGINT to the stage, which is a process of its own.
DVC = """#!{python}
import os, pathlib, signal, subprocess, sys, time
import psutil
words, stages = sys.argv[1:4], sys.argv[4:]
assert words == ["--wait-for-lock", "repro", "--single-item"]
def note(what):
    with open("calls", "a") as file:
        file.write(what + " " + " ".join(stages) + "\\n")
if "stubborn" in stages[0]:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
seconds = 60 if "long" in stages[0] else 3 if "slow" in stages[0] else 0.3
open("niceness", "a").write(f"{{os.nice(0)}} {{stages[0]}}\\n")
stage = subprocess.Popen(["sleep", str(seconds)])
signal.signal(signal.SIGINT, signal.SIG_IGN)
open("pids", "a").write(f"{{os.getpid()}} {{stage.pid}}\\n")
note("begin")
print("the first of many lines")
for line in range(50):
    print("line", line)
ended = stage.wait()
if "failing" in stages[0]:
    pathlib.Path("aside").write_text(str(os.getpid()))
    os.rename("aside", "failing.pid")
if "outliving" in stages[0]:  # until it was noticed that the failing one has ended
    pid = pathlib.Path("failing.pid")
    while not pid.exists() or psutil.pid_exists(int(pid.read_text())):
        time.sleep(0.02)
note("end")
sys.exit(7 if "failing" in stages[0] else abs(ended))
"""


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with that `dvc` on the path."""
    program = tmp_path / "bin" / "dvc"
    program.parent.mkdir()
    program.write_text(DVC.format(python=sys.executable), encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(schedule, "DVC", (program.as_posix(),))
    return tmp_path


def made(
    place: Path,
    slots: int,
    cores: int | None = None,
    more: Callable[[Job], Sequence[Job]] = lambda done: (),
) -> Schedule:
    return Schedule(slots, cores, os.environ, place, more)


def job(name: str, *after: str, place: int = 0) -> Job:
    return Job(name, (f"first@{name}", f"second@{name}"), frozenset(after), place)


def calls(place: Path) -> list[tuple[str, str]]:
    """What was written down: begin or end, and the job."""
    lines = [line.split() for line in (place / "calls").read_text().splitlines()]
    return [(words[0], words[1].partition("@")[2]) for words in lines]


@pytest.mark.parametrize("slots", [1, 2, 3])
def test_so_many_are_at_work_and_never_more(place: Path, slots: int) -> None:
    made(place, slots).run([job(name) for name in "abcdef"])
    at_work, most = 0, 0
    for what, _ in calls(place):
        at_work += 1 if what == "begin" else -1
        most = max(most, at_work)
    assert most == slots and at_work == 0


def test_a_job_begins_when_those_before_it_are_done(place: Path) -> None:
    made(place, 4).run([job("b", "a"), job("a"), job("d", "b", "c"), job("c", "a")])
    order = calls(place)
    for later, earlier in [("b", "a"), ("c", "a"), ("d", "b"), ("d", "c")]:
        assert order.index(("end", earlier)) < order.index(("begin", later))


def test_jobs_that_come_of_others_run_and_those_of_a_lower_place_first(place: Path) -> None:
    def more(done: Job) -> list[Job]:
        return [job("a", place=0), job("c", "a", place=0)] if done.name == "b" and not again else []

    again: list[str] = []

    def once_more(done: Job) -> list[Job]:
        found = more(done)
        again.extend(done.name for _ in found)
        return found

    made(place, 1, more=once_more).run([job("a"), job("b", "a"), job("later", place=1)])
    assert [name for what, name in calls(place) if what == "begin"] == ["a", "b", "a", "c", "later"]


def test_a_job_does_not_wait_for_one_of_a_higher_place_and_is_less_nice(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made(place, 2).run([job("a"), job("b", "a"), job("c", "a"), job("slow", place=1), job("last", place=1)])
    order, told = calls(place), capsys.readouterr().out
    assert told.index("slow: begun") < told.index("a: done")  # it filled the gap
    assert order.index(("begin", "c")) < order.index(("end", "slow"))
    assert order.index(("end", "c")) < order.index(("begin", "last"))  # which takes no third slot
    lines = (place / "niceness").read_text().split()
    niceness = dict(zip(lines[1::2], map(int, lines[::2]), strict=True))
    assert niceness["first@slow"] - niceness["first@c"] == 5


@pytest.mark.parametrize(("cores", "jobs", "shares"), [(8, 1, ["8"]), (8, 2, ["4", "4"]), (1, 2, ["1", "1"])])
def test_processes_share_out_the_cores(
    place: Path, monkeypatch: pytest.MonkeyPatch, cores: int, jobs: int, shares: list[str]
) -> None:
    monkeypatch.delenv(CORES_VARIABLE, raising=False)
    found = []
    schedule_ = made(place, 4, cores)
    share = schedule_._share
    monkeypatch.setattr(schedule_, "_share", lambda ready: found.append(share(ready)) or found[-1])
    schedule_.run([job(str(index)) for index in range(jobs)])
    assert [environment[CORES_VARIABLE] for environment in found] == shares
    assert all(environment["OMP_NUM_THREADS"] == environment[CORES_VARIABLE] for environment in found)


def test_what_the_user_set_stays(place: Path) -> None:
    given = {CORES_VARIABLE: "7", "OTHER": "x"}
    assert Schedule(2, None, given, place, lambda done: ())._share(2) == given


def test_a_process_runs_its_stages_in_their_order_and_what_it_says_is_in_its_log(place: Path) -> None:
    made(place, 1).run([job("a")])
    assert (place / "calls").read_text().splitlines()[0] == "begin first@a second@a"
    assert (place / "a.log").read_text().startswith("the first of many lines\n")


def test_after_a_failure_none_begins_and_those_at_work_finish(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(BelvedereError, match="failing failed with status 7") as told:
        made(place, 2).run([job("failing"), job("outliving"), job("after", "failing"), job("later")])
    assert {name for _, name in calls(place)} == {"failing", "outliving"}
    assert ("end", "outliving") in calls(place)
    assert "line 49" in str(told.value) and "the first of many" not in str(told.value)
    assert "failing.log" in str(told.value)
    assert "failing: failed" in capsys.readouterr().out


@pytest.mark.usefixtures("handled_signals")
@pytest.mark.parametrize("name", ["long", "long-stubborn"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupt_ends_all_that_was_started(
    place: Path, monkeypatch: pytest.MonkeyPatch, name: str, number: signal.Signals
) -> None:
    patient = [(ending, 0.5) for ending, _ in schedule._ENDINGS]
    monkeypatch.setattr(schedule, "_ENDINGS", patient)
    once(lambda: pids(place, 2), lambda: os.kill(os.getpid(), number))
    before = signal.getsignal(number)
    with pytest.raises(KeyboardInterrupt):
        made(place, 2).run([job(f"{name}-1"), job(f"{name}-2"), job(f"{name}-3")])
    assert len(started := pids(place, 2)) == 4  # two of `dvc` and their stages; the third job never began
    assert not [pid for pid in started if alive(pid)]
    assert signal.getsignal(number) == before


def test_nothing_is_left_running_where_it_cannot_go_on(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A closed pipe, as of `./run --jobs 2 | head`, a full disk."""

    def closed(*words: object, **named: object) -> None:
        if "long-2" in str(words):
            while not pids(place, 2):
                time.sleep(0.02)
            raise BrokenPipeError

    monkeypatch.setattr("builtins.print", closed)
    with pytest.raises(BrokenPipeError):
        made(place, 2).run([job("long-1"), job("long-2")])
    assert len(started := pids(place, 2)) == 4
    assert not [pid for pid in started if alive(pid)]


def once(condition: Callable[[], object], act: Callable[[], None]) -> None:
    """Acts in another thread as soon as the condition holds, which it has to within half a minute."""

    def wait() -> None:
        until = time.monotonic() + 30
        while not condition() and time.monotonic() < until:
            time.sleep(0.02)
        act()

    threading.Thread(target=wait, daemon=True).start()


def pids(place: Path, processes: int) -> list[int]:
    """The processes that were started, once as many called `dvc` as are waited for; empty before."""
    calls = (place / "calls").read_text().splitlines() if (place / "calls").exists() else []
    if len(calls) < processes:
        return []
    return [int(word) for word in (place / "pids").read_text().split()]


def alive(pid: int) -> bool:
    return psutil.pid_exists(pid) and psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
