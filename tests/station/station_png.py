"""`python -m tests.station.station_png docs/station.png`: a picture of the page in the middle of a trial."""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image

from pipeline.station.started import Started
from tests.station.browser import Watched, chromium_browser
from tests.station.participant import SIMULATED_CLOCK, Participant, Walk
from tests.station.sessions import small_station

_MOST_BYTES = 150_000
_COLOURS = 256


def trial_page(chromium: str, folder: Path) -> bytes:
    """A screenshot of the real station during a trial of the task with the obstacle, as PNG."""
    changed = {"views_per_task": 1, "trials": 1, "picture": [640, 480], "renderer": "auto"}
    small_station(folder, tasks=["panda_2dof_obstacle"], practice_s=[0, 60], **changed)
    with (
        Started(["--study", "study", "--port", "0"], folder) as station,
        chromium_browser(chromium) as browser,
    ):
        watched = Watched(browser, width=1120, height=900)
        watched.context.add_init_script(SIMULATED_CLOCK)
        watched.page.goto(station.link)
        watched.connect_pad()
        participant, name = Participant(watched, Walk(folder)), ""
        while (name := participant.page(name)) != "trial":
            participant.go_on(name)
        watched.page.wait_for_selector("canvas:not(.empty)")
        watched.page.evaluate("simulated(0.2)")
        watched.sticks(left=(0.3, 0), right=(0, -0.3))
        watched.wait(2.5)  # the bar tells of the last seconds
        return watched.page.screenshot()


def main(out: Path) -> None:
    """Writes the picture with few colours, so that it is small."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        raise SystemExit("there is no Chromium on PATH.")
    with tempfile.TemporaryDirectory() as folder:
        shot = Image.open(io.BytesIO(trial_page(chromium, Path(folder)))).convert("RGB")
    shot.quantize(_COLOURS, dither=Image.Dither.NONE).save(out, optimize=True)
    size = out.stat().st_size
    if size > _MOST_BYTES:
        raise SystemExit(f"{out} has {size} bytes, more than {_MOST_BYTES}.")
    print(f"wrote {out}, {size} bytes")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
