"""What all tests share: the options, what a machine lacks, and a clone of the repository to work in."""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support import Clone, clone_repository


def _choose_opengl() -> None:
    """Chooses the OpenGL that MuJoCo takes; at import, since any test file may import MuJoCo."""
    if sys.platform == "linux" and "MUJOCO_GL" not in os.environ:
        try:
            ctypes.CDLL("libEGL.so.1")
        except OSError:
            os.environ["MUJOCO_GL"] = "disable"
        else:
            os.environ["MUJOCO_GL"] = "egl"


_choose_opengl()

REQUIRE_EGL = "BELVEDERE_REQUIRE_EGL"
REQUIRE_CHROMIUM = "BELVEDERE_REQUIRE_CHROMIUM"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--slow", action="store_true", help="also run the tests that take minutes")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    slow = pytest.mark.skip(reason="not run: slow (--slow runs it)")
    for item in items:
        if item.get_closest_marker("slow") and not config.getoption("--slow"):
            item.add_marker(slow)


@pytest.fixture(autouse=True)
def _what_the_machine_lacks(request: pytest.FixtureRequest) -> None:
    if request.node.get_closest_marker("egl"):
        request.getfixturevalue("egl")
    if request.node.get_closest_marker("chromium"):
        request.getfixturevalue("chromium")
    if request.node.get_closest_marker("gpu"):
        request.getfixturevalue("gpu")


@pytest.fixture(scope="session")
def egl() -> None:
    """Passes over the tests that need MuJoCo's own renderer where it cannot run, or fails them there."""
    import mujoco

    try:
        mujoco.GLContext(8, 8).free()
    except Exception as error:  # the drivers' ways to fail are many
        if os.environ.get(REQUIRE_EGL) == "1":
            pytest.fail(f"{REQUIRE_EGL} is set, yet there is no EGL: {error}")
        pytest.skip("not run: no EGL")


@pytest.fixture(scope="session")
def chromium() -> str:
    """Where Chromium is; passes over the tests that look at the page where it is not, or fails them there."""
    place = shutil.which("chromium") or shutil.which("chromium-browser")
    if place is None and os.environ.get(REQUIRE_CHROMIUM) == "1":
        pytest.fail(f"{REQUIRE_CHROMIUM} is set, yet there is no Chromium")
    if place is None:
        pytest.skip("not run: no Chromium")
    return place


@pytest.fixture(scope="session")
def gpu() -> None:
    """Passes over the tests that need a CUDA device where there is none."""
    import torch

    if not torch.cuda.is_available():
        pytest.skip("not run: no CUDA device")


@pytest.fixture
def handled_signals() -> Iterator[None]:
    """Setpoints to end are heeded, as on a terminal: what was started by nohup or `&` ignores them."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    ignored = [number for number in numbers if signal.getsignal(number) == signal.SIG_IGN]
    for number in ignored:
        signal.signal(number, signal.default_int_handler)
    yield
    for number in ignored:
        signal.signal(number, signal.SIG_IGN)


@pytest.fixture
def clone(tmp_path: Path) -> Clone:
    """A clone of the working tree, in a folder with spaces in its name."""
    return clone_repository(tmp_path / "a clone of it")
