"""The page in headless Chromium: nothing fetched, nothing complained of, readable by all (axe-core)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, sync_playwright

from tests.stages.report_page import PAGE, build
from tests.stages.report_study import VIEWS, write_study

pytestmark = pytest.mark.chromium

LOOKS = [("light", 1280), ("dark", 1280), ("light", 380)]  # colours, width in CSS pixels


@dataclass
class Opened:
    """A page that was opened, what it asked for, and what it complained of."""

    page: Page
    requests: list[str]
    complaints: list[str]


@pytest.fixture(scope="module")
def browser(chromium: str) -> Iterator[Browser]:
    with sync_playwright() as playwright:
        # No sandbox: root, as in a container, may have none. The page is our own.
        opened = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("browser")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("BELVEDERE_SCRATCH", str(folder / "scratch"))
        fetch = dict(list(VIEWS["fetch_reach"].items())[:2])
        write_study(
            folder, {"panda_2dof": VIEWS["panda_2dof"], "fetch_reach": fetch}, opened=("fetch_reach",)
        )
        build()
    return folder / PAGE


@pytest.fixture(scope="module", params=LOOKS, ids=lambda look: f"{look[0]}-{look[1]}")
def opened(request: pytest.FixtureRequest, browser: Browser, file: Path) -> Iterator[Opened]:
    scheme, width = request.param
    context = browser.new_context(color_scheme=scheme, viewport={"width": width, "height": 900})
    shown = Opened(context.new_page(), [], [])
    shown.page.on("request", lambda asked: shown.requests.append(asked.url))
    shown.page.on("console", lambda message: shown.complaints.append(message.text))
    shown.page.on("pageerror", lambda error: shown.complaints.append(str(error)))
    shown.page.goto(file.as_uri(), wait_until="load")
    yield shown
    context.close()


def test_it_fetches_nothing_and_complains_of_nothing(opened: Opened, file: Path) -> None:
    assert [url for url in opened.requests if not url.startswith("data:")] == [file.as_uri()]
    assert opened.complaints == []


def test_pictures_and_clips_are_there(opened: Opened) -> None:
    widths = opened.page.evaluate("Array.from(document.images, image => image.naturalWidth)")
    assert len(widths) >= 4 * 5 and min(widths) > 0  # large, small, clip, reconstructions of five views


def test_it_is_as_wide_as_its_window(opened: Opened) -> None:
    wide = opened.page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
    assert wide <= 0


def test_axe_finds_no_barrier(opened: Opened) -> None:
    found = Axe().run(opened.page)
    assert found.violations_count == 0, found.generate_report()


def test_axe_would_find_one(browser: Browser) -> None:
    page = browser.new_page()
    page.set_content("<p style='color: #ccc; background: #fff'>pale <img src='data:,'></p>")
    assert Axe().run(page).violations_count > 0
    page.close()


def test_a_clip_stands_still_for_those_who_ask_for_it(browser: Browser, file: Path) -> None:
    context = browser.new_context(reduced_motion="reduce")
    page = context.new_page()
    page.goto(file.as_uri(), wait_until="load")
    moving = page.evaluate("Array.from(document.querySelectorAll('picture img'), i => i.currentSrc == i.src)")
    context.close()
    assert len(moving) == 5 and not any(moving)
