"""The arm is driven from the page: inputs, buttons, and pictures that are drawn, dropped and acknowledged."""

from __future__ import annotations

import struct
from typing import Any

import pytest

from tests.station.browser import ToldStation, Watched, picture
from tests.station.browser_pages import PAGES

pytestmark = pytest.mark.chromium
A, BACK, START = 0, 8, 9


@pytest.fixture
def driving(watched: Watched, told: ToldStation) -> Watched:
    told.show("trial", **PAGES["trial"])
    watched.shown("trial")
    return watched


def inputs(told: ToldStation) -> list[dict[str, Any]]:
    return [message for message in told.received if message["type"] == "input"]


def buttons(told: ToldStation) -> list[str]:
    return [message["name"] for message in told.received if message["type"] == "button"]


def drawn(told: ToldStation, frame: int) -> dict[str, Any]:
    return told.wait_for(lambda message: message["type"] == "drawn" and message["frame"] >= frame)


def grey(watched: Watched) -> int:
    """The red of the canvas's middle pixel."""
    return watched.page.evaluate(
        "document.querySelector('canvas').getContext('2d').getImageData(320, 240, 1, 1).data[0]"
    )


def test_sticks_are_sent_raw_and_when_they_change(driving: Watched, told: ToldStation) -> None:
    driving.sticks(left=(0.05, -0.7), right=(0.3, 1.0))
    found = told.wait_for(lambda message: message.get("left") == [0.05, -0.7])
    assert found["right"] == [0.3, 1.0] and found["source"] == "gamepad"
    assert found["device"].startswith("Test Gamepad")
    numbers = [message["seq"] for message in inputs(told)]
    assert numbers == list(range(1, len(numbers) + 1))


def test_sticks_that_rest_are_told_five_times_a_second_at_least(driving: Watched, told: ToldStation) -> None:
    told.wait_for(lambda message: message["type"] == "input")
    before = len(inputs(told))
    driving.wait(2.0)
    assert 10 <= len(inputs(told)) - before <= 14


def test_no_input_is_sent_but_where_the_arm_is_driven(watched: Watched, told: ToldStation) -> None:
    told.show("ready", **PAGES["ready"])
    watched.shown("ready")
    watched.sticks(left=(1, 0))
    watched.wait(0.4)
    assert inputs(told) == []


def test_buttons_count_once_a_press(driving: Watched, told: ToldStation) -> None:
    for button in (START, BACK, A):
        driving.press(button)
    told.wait_for(lambda message: message.get("name") == "a")
    driving.wait(0.1)
    assert buttons(told) == ["start", "pause", "a"]


def test_a_button_that_is_held_from_the_page_before_does_not_end_the_trial(
    watched: Watched, told: ToldStation
) -> None:
    told.show("ready", **PAGES["ready"])
    watched.shown("ready")
    watched.page.evaluate("pad.buttons[0] = {pressed: true, value: 1}")
    watched.page.keyboard.down("Enter")
    told.wait_for(lambda message: message["type"] == "answer")
    told.show("trial", **PAGES["trial"])
    watched.shown("trial")
    watched.page.keyboard.down("Enter")  # the key repeats
    watched.wait(0.2)
    assert buttons(told) == []


def test_keys_are_sticks_and_are_told_as_keys(driving: Watched, told: ToldStation) -> None:
    for key in ("KeyW", "KeyD", "ArrowUp"):
        driving.page.keyboard.down(key)
    found = told.wait_for(lambda message: message.get("left") == [1, -1] and message.get("right") == [0, -1])
    assert (found["source"], found["device"]) == ("keyboard", "keyboard")
    for key in ("KeyW", "KeyD", "ArrowUp"):
        driving.page.keyboard.up(key)
    count = len(inputs(told))
    told.wait_for(lambda message: message.get("seq", 0) > count and message.get("left") == [0, 0])
    for key in ("Space", "KeyP", "Enter"):
        driving.page.keyboard.press(key)
    told.wait_for(lambda message: message.get("name") == "a")
    assert buttons(told) == ["start", "pause", "a"]


def test_whoever_moves_last_has_the_arm(driving: Watched, told: ToldStation) -> None:
    driving.page.keyboard.down("KeyW")
    told.wait_for(lambda message: message.get("source") == "keyboard")
    driving.sticks(left=(0.9, 0))
    told.wait_for(lambda message: message.get("left") == [0.9, 0] and message["source"] == "gamepad")


def test_a_window_without_the_focus_lets_go_of_the_keys(driving: Watched, told: ToldStation) -> None:
    driving.page.keyboard.down("KeyW")
    told.wait_for(lambda message: message.get("left") == [0, -1])
    driving.page.evaluate("dispatchEvent(new Event('blur'))")
    count = len(inputs(told))
    told.wait_for(lambda message: message.get("seq", 0) > count and message["left"] == [0, 0])


@pytest.mark.parametrize("happened", ["hidden", "gamepad gone"])
def test_the_arm_is_paused_where_nobody_can_drive_it(
    driving: Watched, told: ToldStation, happened: str
) -> None:
    told.wait_for(lambda message: message.get("source") == "gamepad")
    if happened == "hidden":
        driving.page.evaluate(
            "Object.defineProperty(document, 'hidden', {value: true});"
            "document.dispatchEvent(new Event('visibilitychange'))"
        )
    else:
        driving.page.evaluate("pad = null")
    told.wait_for(lambda message: message.get("name") == "pause")


def test_the_pause_button_pauses_and_its_keys_do_not_drive(driving: Watched, told: ToldStation) -> None:
    driving.page.keyboard.press("Tab")
    driving.page.keyboard.press("Space")
    told.wait_for(lambda message: message.get("name") == "pause")
    assert buttons(told) == ["pause"]


def test_a_picture_is_drawn_and_acknowledged(driving: Watched, told: ToldStation) -> None:
    seq = told.wait_for(lambda message: message["type"] == "input")["seq"]
    told.send(picture(1, seq, grey=200))
    first = drawn(told, 1)
    assert first["frame"] == 1 and first["latency_ms"] > 0
    assert abs(grey(driving) - 200) <= 2
    told.send(picture(2, seq, grey=60))
    assert drawn(told, 2) == {"type": "drawn", "frame": 2, "latency_ms": None}  # no newer input in it
    assert abs(grey(driving) - 60) <= 2


def test_latency_counts_from_the_read_of_the_input(driving: Watched, told: ToldStation) -> None:
    seq = told.wait_for(lambda message: message["type"] == "input")["seq"]
    driving.wait(0.5)
    told.send(picture(1, seq))
    assert drawn(told, 1)["latency_ms"] >= 500


def test_a_picture_that_comes_late_is_dropped(driving: Watched, told: ToldStation) -> None:
    told.send(picture(5, grey=200))
    drawn(told, 5)
    told.send(picture(4, grey=20))
    driving.wait(0.3)
    assert abs(grey(driving) - 200) <= 2
    told.send(picture(6, grey=90))
    drawn(told, 6)
    frames = [message["frame"] for message in told.received if message["type"] == "drawn"]
    assert frames == [5, 6]


def test_many_pictures_at_once_end_with_the_newest(driving: Watched, told: ToldStation) -> None:
    for frame in range(1, 31):
        told.send(picture(frame, grey=8 * frame))
    drawn(told, 30)
    assert abs(grey(driving) - 240) <= 2
    frames = [message["frame"] for message in told.received if message["type"] == "drawn"]
    assert frames == sorted(set(frames)) and frames[-1] == 30


def test_nothing_of_the_view_before_is_seen_in_the_next_trial(driving: Watched, told: ToldStation) -> None:
    told.send(picture(1, grey=200))
    drawn(told, 1)
    told.show("ready", **PAGES["ready"])
    driving.shown("ready")
    told.send(picture(2, grey=150))  # it was on its way
    assert drawn(told, 2)["frame"] == 2
    told.show("trial", **PAGES["trial"])
    driving.shown("trial")
    driving.wait(0.2)
    assert not driving.page.locator("canvas").is_visible()
    assert grey(driving) == 0
    told.send(picture(3, grey=90))
    drawn(told, 3)
    assert driving.page.locator("canvas").is_visible()


def test_a_damaged_picture_is_acknowledged_and_the_next_one_drawn(
    driving: Watched, told: ToldStation
) -> None:
    seq = told.wait_for(lambda message: message["type"] == "input")["seq"]
    told.send(picture(1, seq)[:200])
    assert drawn(told, 1)["latency_ms"] is None
    told.send(picture(2, seq, grey=200))
    assert drawn(told, 2)["latency_ms"] > 0
    assert abs(grey(driving) - 200) <= 2


@pytest.mark.parametrize("message", [b"", bytes(16), struct.pack("<4I", 1, 0, 0, 7) + b"picture"])
def test_a_binary_message_that_is_no_picture_ends_with_an_explanation(
    driving: Watched, told: ToldStation, message: bytes
) -> None:
    told.send(message)
    driving.shown("error")
    assert "do not understand each other" in driving.page.inner_text("h1")


def test_the_bar_says_how_the_station_runs(driving: Watched, told: ToldStation) -> None:
    told.send(
        {
            "type": "status",
            "renderer": "ray tracer",
            "picture": [320, 240],
            "fps": 24.96,
            "latency_ms_p50": 41.4,
        }
        | {"latency_ms_p95": None, "real_time_factor": 0.9712, "flags": ["real_time", "latency"]}
    )
    driving.page.wait_for_selector("#bar .flags:not(:empty)")
    bar = driving.page.inner_text("#bar")
    for part in ("ray tracer 320 × 240", "25.0 pictures/s", "latency 41 ms, p95 – ms", "real time × 0.97"):
        assert part in bar
    assert "slower than real time, latency above 100 ms" in bar
