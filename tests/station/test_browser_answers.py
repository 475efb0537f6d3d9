"""What the participant presses and marks is what the station hears; when a page can be left, and how."""

from __future__ import annotations

from typing import Any

import pytest

from tests.station.browser import ToldStation, Watched
from tests.station.browser_pages import PAGES

pytestmark = pytest.mark.chromium
A, BACK, START = 0, 8, 9


def show(told: ToldStation, watched: Watched, name: str, **others: Any) -> None:
    told.show(name, **{**PAGES[name], **others})
    watched.shown(name)


def answers(told: ToldStation) -> list[dict[str, Any]]:
    return [message for message in told.received if message["type"] == "answer"]


def answered(told: ToldStation) -> dict[str, Any]:
    return told.wait_for(lambda message: message["type"] == "answer")


def test_hello_comes_first_and_names_the_protocol(watched: Watched, told: ToldStation) -> None:
    assert told.received[0] == {"type": "hello", "protocol": 1}


def test_consent_is_ticked_and_then_given(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "consent")
    accept = watched.page.get_by_role("button", name="Agree")
    assert accept.is_disabled()
    watched.press(A)
    watched.page.keyboard.press("Enter")
    assert answers(told) == []
    watched.page.get_by_role("checkbox").check()
    watched.press(A)
    assert answers(told) == []
    accept.click()
    values = {"accepted": True, "version": "belvedere-1"}
    assert answered(told) == {"type": "answer", "page": "consent", "values": values}


def test_consent_is_refused_without_a_tick(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "consent")
    watched.page.get_by_role("button", name="do not").click()
    assert answered(told)["values"]["accepted"] is False


@pytest.mark.parametrize("name", ["instructions", "ready", "feedback", "break"])
@pytest.mark.parametrize("by", ["gamepad", "Enter", "mouse"])
def test_a_page_is_left_by_any_of_three_ways_and_once(
    watched: Watched, told: ToldStation, name: str, by: str
) -> None:
    show(told, watched, name)
    for _ in range(2):
        if by == "gamepad":
            watched.press(A)
        elif by == "Enter":
            watched.page.keyboard.press("Enter", delay=40)
        else:
            watched.page.locator("main button").click()
    answered(told)
    watched.wait(0.1)
    assert answers(told) == [{"type": "answer", "page": name, "values": {}}]


def test_a_pause_ends_by_resume(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "paused")
    watched.press(A)
    assert told.wait_for(lambda message: message["type"] == "button")["name"] == "resume"


def gamepad_steps(watched: Watched) -> None:
    """All that the gamepad test asks for."""
    watched.page.wait_for_selector(".steps li:nth-child(1).done")
    for way in [(0, -1), (0, 1), (-1, 0), (1, 0)]:
        watched.sticks(left=way)
        watched.wait(0.08)
    for way in [(0, -1), (0, 1)]:
        watched.sticks(right=way)
        watched.wait(0.08)
    watched.sticks()
    watched.press(A)
    watched.press(START)


def test_a_gamepad_that_works_goes_on(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "gamepad")
    watched.sticks(left=(0.03, 0.04))
    go_on = watched.page.get_by_role("button", name="Go on with the gamepad")
    watched.wait(0.2)
    assert go_on.is_disabled()
    watched.wait(2.2)
    gamepad_steps(watched)
    go_on.click()
    values = answered(told)["values"]
    assert values["source"] == "gamepad" and values["mapping"] == "standard"
    assert values["device"].startswith("Test Gamepad") and values["window"] == [1280, 900]
    assert values["drift"] == pytest.approx(0.05)


def test_a_button_that_does_not_work_is_missed(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "gamepad")
    watched.page.evaluate("Object.defineProperty(pad.buttons, 9, {get: () => ({pressed: false})})")
    gamepad_steps(watched)
    assert watched.page.locator(".steps li:not(.done)").inner_text().startswith("Button Start")
    assert watched.page.get_by_role("button", name="Go on with the gamepad").is_disabled()


def test_a_stick_that_drifts_past_the_dead_zone_is_told(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "gamepad")
    watched.sticks(right=(0, 0.2))
    watched.page.wait_for_selector(".drift.bad", timeout=5000)
    assert "20.0 % off their centre, more than the 12 %" in watched.page.inner_text(".drift")


def test_a_gamepad_of_another_mapping_is_told_and_not_used(watched: Watched, told: ToldStation) -> None:
    watched.connect_pad(mapping="")
    show(told, watched, "gamepad")
    watched.page.wait_for_selector(".told.bad")
    assert "no standard mapping" in watched.page.inner_text(".told")
    assert watched.page.get_by_role("button", name="Go on with the gamepad").is_disabled()
    watched.page.get_by_role("button", name="keyboard").click()
    values = answered(told)["values"]
    assert (values["source"], values["device"], values["drift"]) == ("keyboard", "keyboard", 0)


def test_a_gamepad_that_goes_away_is_told(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "gamepad")
    watched.page.wait_for_function("document.querySelector('.told').textContent.startsWith('Connected')")
    watched.page.evaluate("pad = null")
    watched.page.wait_for_selector(".told.bad")
    assert "is gone" in watched.page.inner_text(".told")


def test_tlx_by_the_keyboard_alone(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "tlx")
    keys = watched.page.keyboard
    for press in ["ArrowRight", "Home", "End", "PageUp", "ArrowLeft", "Enter"]:
        keys.press("Tab")
        keys.press(press)
    keys.press("Tab")
    keys.press("Enter")
    values = answered(told)["values"]
    # a step of 5 up from the middle; both ends; a page of steps, as the browser has it; the middle itself
    page_up = values.pop("performance")
    assert page_up > 50 and page_up % 5 == 0
    assert values == {"mental": 55, "physical": 0, "temporal": 100, "effort": 45, "frustration": 50}


def test_tlx_without_a_mark_is_not_sent(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "tlx")
    for scale in ["mental", "physical", "temporal", "performance", "effort"]:
        watched.page.focus(f"#tlx-{scale}")
        watched.page.keyboard.press("ArrowRight")
    watched.page.get_by_role("button").click()
    assert watched.page.inner_text("[role=status].note") == "Still to answer: Frustration."
    assert watched.page.evaluate("document.activeElement.id") == "tlx-frustration"
    assert answers(told) == []


def test_practice_ends_no_sooner_than_its_shortest_time(watched: Watched, told: ToldStation) -> None:
    show(told, watched, "practice", elapsed_s=299.0)
    begin = watched.page.get_by_role("button", name="Begin the trials")
    assert begin.is_disabled()
    assert watched.page.inner_text(".clock") == "The trials can begin in 0:01"
    begin.click(timeout=5000)  # waits until it can be pressed
    assert answered(told) == {"type": "answer", "page": "practice", "values": {}}
    assert watched.page.inner_text(".clock") in ("Practice ends in 10:00", "Practice ends in 9:59")


@pytest.mark.parametrize(
    ("outcome", "told_text"),
    [("grasped", "Time 7.3 s, distance to the ball's centre 12 mm."), ("timeout", "The time was up.")],
)
def test_feedback_says_what_was_measured(
    watched: Watched, told: ToldStation, outcome: str, told_text: str
) -> None:
    show(told, watched, "feedback", outcome=outcome)
    assert watched.page.inner_text("p.lede") == told_text
