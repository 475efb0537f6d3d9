"""Chromium and the told station, once for all files of tests that look at the page."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from tests.station.browser import ToldStation, Watched, chromium_browser


@pytest.fixture(scope="module")
def browser(chromium: str) -> Iterator[Browser]:
    with chromium_browser(chromium) as opened:
        yield opened


@pytest.fixture(scope="module")
def told() -> Iterator[ToldStation]:
    station = ToldStation()
    yield station
    station.stop()


@pytest.fixture
def watched(browser: Browser, told: ToldStation) -> Iterator[Watched]:
    """The station's page, open and connected, with a gamepad that does nothing yet."""
    shown = Watched(browser)
    told.opened()
    shown.page.goto(told.address)
    told.wait_for(lambda message: message["type"] == "hello")
    shown.connect_pad()
    yield shown
    shown.context.close()
