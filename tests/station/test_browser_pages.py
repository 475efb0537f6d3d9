"""Every page in headless Chromium, light, dark and small: readable by all (axe-core), and by itself."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser

from tests.station.browser import ToldStation, Watched, picture
from tests.station.browser_pages import PAGES, STATUS

pytestmark = pytest.mark.chromium

LOOKS = [("light", 1280, 900), ("dark", 1280, 900), ("light", 400, 800), ("dark", 400, 640)]


@pytest.fixture(scope="module", params=LOOKS, ids=lambda look: "-".join(map(str, look)))
def looked(request: pytest.FixtureRequest, browser: Browser, told: ToldStation) -> Iterator[Watched]:
    shown = Watched(browser, *request.param)
    told.opened()
    shown.page.goto(told.address)
    told.wait_for(lambda message: message["type"] == "hello")
    shown.connect_pad()
    yield shown
    shown.context.close()


@pytest.fixture(params=PAGES, ids=str)
def page(request: pytest.FixtureRequest, looked: Watched, told: ToldStation) -> Watched:
    name: str = request.param
    told.show(name, **PAGES[name])
    looked.shown(name)
    if name in ("practice", "trial"):
        told.send(STATUS)
        told.send(picture(looked.page.evaluate("(window.frames_sent = (window.frames_sent ?? 0) + 1)")))
        looked.page.wait_for_selector("canvas:not(.empty)")
        looked.page.wait_for_selector("#bar .rate:not(:empty)")
    if name == "gamepad":
        looked.page.wait_for_selector(".steps .done", timeout=10_000)  # the sticks rest
    return looked


def test_a_page_has_no_barrier_gap_or_stranger(page: Watched, told: ToldStation) -> None:
    found = Axe().run(page.page)
    assert found.violations_count == 0, found.generate_report()
    assert page.page.evaluate("document.documentElement.scrollWidth - window.innerWidth") <= 0
    assert page.page.evaluate("document.activeElement.tagName") == "H1"
    text = page.page.inner_text("body")
    assert "{" not in text and "undefined" not in text and "NaN" not in text
    assert all(url.startswith(told.address) for url in page.requests)
    assert page.complaints == []


def test_the_picture_takes_the_window(looked: Watched, told: ToldStation) -> None:
    told.show("trial", **PAGES["trial"])
    looked.shown("trial")
    told.send(picture(looked.page.evaluate("(window.frames_sent = (window.frames_sent ?? 0) + 1)")))
    looked.page.wait_for_selector("canvas:not(.empty)")
    box = looked.page.locator("canvas").bounding_box()
    size = looked.page.viewport_size
    assert box is not None and size is not None
    shown = min(box["width"], box["height"] * 4 / 3)
    assert shown >= min(0.9 * size["width"], 0.85 * size["height"] * 4 / 3)
    assert looked.page.evaluate("document.documentElement.scrollHeight <= window.innerHeight")


def test_the_picture_has_one_size_in_all_tasks_in_practice_and_beside_a_full_bar(
    watched: Watched, told: ToldStation
) -> None:
    boxes = []
    for number, (name, scene, axes) in enumerate(
        [
            ("trial", "panda_1dof", ["z"]),
            ("trial", "panda_2dof_obstacle", ["y", "z"]),
            ("practice", "fetch_reach", ["x", "y", "z"]),
        ]
    ):
        told.show(name, **{**PAGES[name], "scene": scene, "axes": axes})
        watched.shown(name)
        for status in (STATUS | {"flags": []}, STATUS):
            told.send(picture(2 * number + (status is STATUS) + 1))
            watched.page.wait_for_selector("canvas:not(.empty)")
            boxes.append(watched.page.locator("canvas").bounding_box())
            told.send(status)
            watched.wait(0.1)
    assert boxes == [boxes[0]] * len(boxes)


def test_axe_would_find_a_barrier(watched: Watched) -> None:
    watched.page.evaluate("document.querySelector('main').append(document.createElement('button'))")
    assert Axe().run(watched.page).violations_count > 0


def test_what_the_station_sends_is_text_and_never_html(watched: Watched, told: ToldStation) -> None:
    told.show("error", reason="storage", detail="<b id='made'>full</b>")
    watched.shown("error")
    assert "<b id='made'>full</b>" in watched.page.inner_text("main")
    assert watched.page.query_selector("#made") is None


def test_a_scene_that_the_texts_do_not_name_has_the_default(watched: Watched, told: ToldStation) -> None:
    told.show("ready", **{**PAGES["ready"], "scene": "constructor"})
    watched.shown("ready")
    assert "Bring the gripper to the red ball and press A." in watched.page.inner_text("main")
