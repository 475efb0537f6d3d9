"""The teleoperation station: pictures a second, input to drawn picture, and memory over a run.

A station runs in a process of its own; this one is the page: the scripted operator drives in practice, which
goes through every scene and view, and draws what it is sent. `python -m benchmarks.station --minutes 15` is a
long run.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import tempfile
import threading
from collections.abc import Coroutine
from pathlib import Path

import numpy as np
import psutil
import yaml

from benchmarks.rows import AT_LEAST, AT_MOST, Row, goal_row, header, line
from pipeline.contract import params
from pipeline.contract.yamls import read_yaml
from pipeline.scripted.params import OperatorParams
from pipeline.station.operate import Report, operate
from pipeline.station.params import station_params
from pipeline.station.started import Started

SECONDS = 60.0
RATE, LATENCY_MS, GROWTH_MIB = 24.9, 60.0, 16.0
_SAMPLE_S = 1.0


class Memory(threading.Thread):
    """What a process holds, MiB, once a second from when every view was shown."""

    def __init__(self, process: int, report: Report, views: int) -> None:
        super().__init__(name="memory", daemon=True)
        self._process, self._ends = psutil.Process(process), threading.Event()
        self._report, self._views = report, views
        self.samples: list[float] = []

    def run(self) -> None:
        while not self._ends.wait(_SAMPLE_S):
            try:
                mib = self._process.memory_info().rss / 2**20
            except psutil.NoSuchProcess:
                return
            if self._report.pages.count("practice") > self._views:
                self.samples.append(mib)

    def stop(self) -> None:
        """Ends the watching."""
        self._ends.set()
        self.join()

    def growth_mib(self) -> float | None:
        """By how much the last tenth lies above the first one; None of too short a run."""
        tenth = len(self.samples) // 10
        if tenth < 1:
            return None
        return float(np.median(self.samples[-tenth:]) - np.median(self.samples[:tenth]))


def measure(seconds: float = SECONDS) -> list[Row]:
    """Rows of pictures a second, latencies and memory."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write_parameters(folder, seconds)
        path = folder / params.PARAMS_FILE
        operator, station = params.section(OperatorParams, "operator", path=path), station_params(path)
        words = ["--operator", "scripted", "--study", "study", "--port", "0"]
        with Started(words, folder, quiet=True) as started:
            report = Report()
            memory = Memory(started.process.pid, report, len(station.tasks) * station.views_per_task)
            memory.start()
            driving = operate(started.link, operator, station, np.random.default_rng(1), None, report)
            asyncio.run(_for(seconds, driving))
            memory.stop()
    return _rows(report, memory.growth_mib(), seconds)


def _write_parameters(folder: Path, seconds: float) -> None:
    """The parameters as they are, but for practice that is long enough."""
    tree = read_yaml(params.PARAMS_FILE)
    tree["station"]["practice_s"] = [0, seconds + 120]
    (folder / params.PARAMS_FILE).write_text(yaml.safe_dump(tree, allow_unicode=True), encoding="utf-8")


async def _for(seconds: float, driving: Coroutine[None, None, Report]) -> None:
    """Drives for so long."""
    with contextlib.suppress(TimeoutError):
        await asyncio.wait_for(driving, seconds)


def _rows(report: Report, growth_mib: float | None, seconds: float) -> list[Row]:
    """The rows of a run."""
    size = " × ".join(map(str, report.size))
    note = f"{report.renderer}, {size}"
    rate = len(report.intervals_s) / sum(report.intervals_s) if report.intervals_s else None
    middle, high = np.percentile(report.latencies_ms, [50, 95]) if report.latencies_ms else (None, None)
    work, scenes = "station: {}", "all tasks"
    grown = f"{work.format('memory grown in')} {seconds / 60:.0f} min"
    return [
        goal_row(
            work.format("pictures delivered"), scenes, rate, None, "frames/s", None, RATE, AT_LEAST, note
        ),
        goal_row(
            work.format("input to picture, p50"), scenes, middle, None, "ms", None, LATENCY_MS, AT_MOST, note
        ),
        goal_row(work.format("input to picture, p95"), scenes, high, None, "ms", None, None, AT_MOST, note),
        goal_row(grown, scenes, growth_mib, None, "MiB", None, GROWTH_MIB, AT_MOST, note),
    ]


def main() -> None:
    """Prints the rows of a run."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.station", description=__doc__)
    options.add_argument("--minutes", type=float, default=SECONDS / 60)
    print(header())
    for row in measure(60 * options.parse_args().minutes):
        print(line(row))


if __name__ == "__main__":
    main()
