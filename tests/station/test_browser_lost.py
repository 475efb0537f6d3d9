"""A connection that ends: the page says why, and what to do."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser

from tests.station.browser import ToldStation, Watched
from tests.station.browser_pages import PAGES

pytestmark = pytest.mark.chromium


@pytest.mark.parametrize(
    ("code", "words"),
    [(1001, "station was ended"), (1008, "do not understand"), (1011, "connection is lost")],
)
def test_the_code_of_a_close_is_told_in_words(
    watched: Watched, told: ToldStation, code: int, words: str
) -> None:
    told.show("trial", **PAGES["trial"])
    watched.shown("trial")
    told.end(code)
    watched.shown("error")
    assert words in watched.page.inner_text("h1")
    assert watched.page.evaluate("document.activeElement.tagName") == "H1"


def test_a_second_window_is_told_of_the_first_and_can_take_over_later(
    watched: Watched, told: ToldStation, browser: Browser
) -> None:
    told.refuse = True
    second = Watched(browser)
    second.page.goto(told.address)
    second.shown("error")
    assert "Another window" in second.page.inner_text("h1")
    told.refuse = False
    told.received.clear()
    second.page.get_by_role("button", name="Connect again").click()
    told.wait_for(lambda message: message["type"] == "hello")
    second.context.close()


def test_a_station_that_is_gone_is_told_and_the_page_stays(browser: Browser) -> None:
    station = ToldStation()
    shown = Watched(browser)
    shown.page.goto(station.address)
    station.wait_for(lambda message: message["type"] == "hello")
    station.end(1011)
    station.stop()
    shown.shown("error")
    shown.page.get_by_role("button", name="Connect again").click()
    shown.wait(0.3)
    assert "connection is lost" in shown.page.inner_text("h1")
    shown.context.close()


def test_a_used_link_is_told(watched: Watched, told: ToldStation) -> None:
    watched.page.route("**/web/texts.json", lambda route: route.fulfill(status=403))
    told.end(1011)
    watched.shown("error")
    assert "link is used up" in watched.page.inner_text("h1")


def test_the_end_of_a_session_stays_thanks(watched: Watched, told: ToldStation) -> None:
    told.show("thanks", **PAGES["thanks"])
    watched.shown("thanks")
    told.end(1000)
    watched.wait(0.3)
    assert "k7m2pq" in watched.page.inner_text("main")
    assert watched.page.inner_text("h1") == "Thank you"


def test_a_page_that_is_not_known_is_an_error(watched: Watched, told: ToldStation) -> None:
    told.show("toString")
    watched.shown("error")
    assert "do not understand" in watched.page.inner_text("h1")
