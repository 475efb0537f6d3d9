"""The page's logic, function by function, inside Chromium; where Python has the same, the two agree."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser

from pipeline.station.messages import JPEG, picture_message
from pipeline.station.sticks import pushed
from tests.station.browser import ToldStation, Watched

pytestmark = pytest.mark.chromium


@pytest.fixture(scope="module")
def loaded(browser: Browser, told: ToldStation) -> Iterator[Watched]:
    """The page, for its modules only."""
    shown = Watched(browser)
    told.opened()
    shown.page.goto(told.address)
    yield shown
    shown.context.close()


def call(loaded: Watched, module: str, body: str, argument: Any = None) -> Any:
    """Runs ``body`` with the module as ``m`` and the argument as ``given``; returns what it returns."""
    return loaded.page.evaluate(
        f"async given => {{ const m = await import('/web/{module}.js'); {body} }}", argument
    )


def test_speed_is_what_the_station_makes_of_a_stick(loaded: Watched) -> None:
    rng = np.random.default_rng(4)
    sticks = [*rng.uniform(-1, 1, (200, 2)).tolist(), [0, 0], [0.12, 0], [1, 1], [-1, 0]]
    for zone in (0.0, 0.12, 0.5):
        found = call(loaded, "sticks", "return given[0].map(s => m.speed(s, given[1]));", [sticks, zone])
        wanted = [float(np.linalg.norm(pushed(np.array(stick), zone))) for stick in sticks]
        np.testing.assert_allclose(found, wanted, atol=1e-12)


@pytest.mark.parametrize("axes", [[0, 0], [0.12, 0], [0, -0.12], [0.08, 0.08]])
def test_within_the_dead_zone_nothing_moves(loaded: Watched, axes: list[float]) -> None:
    assert call(loaded, "sticks", "return m.speed(given, 0.12);", axes) == 0


@pytest.mark.parametrize(
    ("stick", "ends"),
    [
        ([0, -1], ["up"]),
        ([0, 1], ["down"]),
        ([-0.95, 0.1], ["left"]),
        ([1, 1], ["down", "right"]),
        ([0.7, 0.7], []),
    ],
)
def test_the_ends_of_a_stick(loaded: Watched, stick: list[float], ends: list[str]) -> None:
    assert call(loaded, "sticks", "return m.ends(given);", stick) == ends


def rest(loaded: Watched, readings: list[tuple[float, float, float]]) -> float | None:
    """The drift measured from readings of (milliseconds, left x, right y)."""
    return call(
        loaded,
        "sticks",
        "const r = new m.Rest(); for (const [t, x, y] of given) r.take([x, 0], [0, y], t); return r.drift;",
        readings,
    )


def test_drift_is_the_largest_while_both_sticks_rest(loaded: Watched) -> None:
    still = [(t, 0.01, -0.02) for t in range(0, 1000, 100)]
    assert rest(loaded, still) is None  # a second is too short
    assert rest(loaded, [*still, (1000.0, 0.0, 0.05), (2000.0, 0.0, 0.0)]) == pytest.approx(0.05)
    assert rest(loaded, [*still, (1000.0, 0.9, 0.0), (2000.0, 0.0, 0.0), (2900.0, 0.0, 0.0)]) is None
    later = [(1000.0, 0.9, 0.0), (2000.0, 0.0, 0.0), (4000.0, 0.03, 0.0)]
    assert rest(loaded, [*still, *later]) == pytest.approx(0.03)


PARSE = """
try {
  const p = m.parsePicture(new Uint8Array(given).buffer);
  return [p.frame, p.seq, p.simulatedMs, p.type, Array.from(p.bytes)];
} catch (error) { return error.name; }
"""


def test_a_header_is_read_as_the_station_writes_it(loaded: Watched) -> None:
    rng = np.random.default_rng(8)
    for frame, seq, milliseconds in [(1, 0, 0), *rng.integers(0, 2**32, (30, 3)).tolist(), (2**32 - 1,) * 3]:
        message = picture_message(frame, seq, milliseconds, b"picture")
        found = call(loaded, "picture", PARSE, list(message))
        assert found == [frame, seq, milliseconds, "image/jpeg", list(b"picture")]
    webp = struct.pack("<4I", 7, 8, 9, 2) + b"x"
    assert call(loaded, "picture", PARSE, list(webp)) == [7, 8, 9, "image/webp", [120]]


def test_a_header_that_is_cut_off_or_stands_alone_is_refused(loaded: Watched) -> None:
    message = picture_message(1, 2, 3, b"p")
    for length in range(len(message)):
        assert call(loaded, "picture", PARSE, list(message[:length])) == "RangeError"
    assert call(loaded, "picture", PARSE, list(message)) == [1, 2, 3, "image/jpeg", [112]]


@pytest.mark.parametrize("form", [0, 3, 2**24 * JPEG])
def test_an_unknown_format_is_refused(loaded: Watched, form: int) -> None:
    assert call(loaded, "picture", PARSE, list(struct.pack("<4I", 1, 2, 3, form) + b"p")) == "RangeError"


def test_pictures_that_are_decoded_out_of_order_do_not_go_back(loaded: Watched) -> None:
    body = """
    const open = [], closed = [];
    const screen = new m.Screen(() => new Promise((done) => open.push(done)));
    const canvas = () => document.createElement("canvas");
    const bitmap = (frame) => Object.assign(canvas(), { close: () => closed.push(frame) });
    const message = (frame) => { const b = new ArrayBuffer(17); const d = new DataView(b);
      d.setUint32(0, frame, true); d.setUint32(4, 10 * frame, true); d.setUint32(12, 1, true); return b; };
    const received = [1, 2, 3].map((frame) => screen.receive(message(frame)));
    open[1](bitmap(2)); await received[1];
    open[0](bitmap(1)); await received[0];
    const first = screen.draw(), none = screen.draw();
    open[2](bitmap(3)); await received[2];
    screen.clear();
    return [first, none, closed, screen.draw(), closed];
    """  # fmt: skip
    first, none, _, last, closed = call(loaded, "picture", body)
    assert first == {"frame": 2, "seq": 20} and none is None
    assert last == {"frame": 3, "seq": None}  # acknowledged, though not drawn
    assert closed == [1, 2, 3]  # all are given back


def test_latency_counts_each_input_once(loaded: Watched) -> None:
    body = """
    const l = new m.Latency();
    for (const [seq, at] of [[1, 100], [2, 120], [3, 140]]) l.read(seq, at);
    return [l.drawn(0, 150), l.drawn(null, 150), l.drawn(2, 160), l.drawn(2, 170), l.drawn(1, 170),
            l.drawn(500, 175), l.drawn(3, 180), l.reads.size];
    """
    assert call(loaded, "latency", body) == [None, None, 40, None, None, None, 40, 0]


def test_latency_is_at_most_what_the_station_takes(loaded: Watched) -> None:
    body = "const l = new m.Latency(); l.read(1, 0); return l.drawn(1, 3.6e6);"
    assert call(loaded, "latency", body) == 60_000


INPUTS = """
let pads = [];
const i = new m.Inputs(() => m.gamepads(pads));
const pad = (axes, down = [], mapping = "standard") => ({ id: "pad", connected: true, mapping, axes,
  buttons: Array.from({ length: 17 }, (_, at) => ({ pressed: down.includes(at) })) });
"""


def test_raw_values_out_of_range_are_brought_into_it(loaded: Watched) -> None:
    body = INPUTS + "pads = [null, pad([1.0001, -7, NaN])]; return i.read();"
    state = call(loaded, "inputs", body)
    assert state["left"] == [1, -1] and state["right"] == [0, 0]


def test_messages_come_no_more_often_than_the_station_takes(loaded: Watched) -> None:
    body = (
        INPUTS
        + """
    let sent = 0;
    for (let at = 0; at < 1000; at += 1000 / 240) {
      pads = [pad([Math.sin(at), 0, 0, 0])];
      sent += i.message(i.read(), at) !== null;
    }
    return sent;
    """
    )
    assert 60 <= call(loaded, "inputs", body) <= 84


def test_opposite_keys_cancel_and_unknown_keys_are_not_ours(loaded: Watched) -> None:
    body = (
        INPUTS
        + """
    const codes = ["KeyW", "KeyS", "KeyA", "ArrowUp", "KeyQ", "F5", "toString"];
    const ours = codes.map((code) => i.key(code, true));
    return [ours, i.read()];
    """
    )
    ours, state = call(loaded, "inputs", body)
    assert ours == [True, True, True, True, False, False, False]
    assert state["left"] == [-1, 0] and state["right"] == [0, -1]


def test_a_key_that_was_tapped_between_two_readings_is_not_lost(loaded: Watched) -> None:
    body = INPUTS + "i.key('Enter', true); i.key('Enter', false); return [i.read(), i.read()];"
    first, second = call(loaded, "inputs", body)
    assert first["pressed"] == ["a"] and second["pressed"] == []


def test_a_gamepad_of_another_mapping_is_not_read(loaded: Watched) -> None:
    body = INPUTS + "pads = [pad([1, 1, 1, 1], [0], '')]; return [i.read(), m.gamepads(pads).unsupported.id];"
    state, other = call(loaded, "inputs", body)
    assert (state["source"], state["left"], state["pressed"], other) == ("keyboard", [0, 0], [], "pad")


@pytest.mark.parametrize(
    ("text", "words", "filled"),
    [
        ("{a} of {b}", {"a": 1, "b": "{a}"}, "1 of {a}"),  # what is filled in is not filled again
        ("{a} {c}", {"a": 0}, "0 {c}"),
        ("{toString}", {}, "{toString}"),
        ("none", {"a": 1}, "none"),
    ],
)
def test_words_are_filled_in(loaded: Watched, text: str, words: dict[str, Any], filled: str) -> None:
    assert call(loaded, "dom", "return m.fill(...given);", [text, words]) == filled


@pytest.mark.parametrize(
    ("seconds", "shown"), [(0, "0:00"), (-3, "0:00"), (59.1, "1:00"), (61.2, "1:02"), (600, "10:00")]
)
def test_a_clock_rounds_up(loaded: Watched, seconds: float, shown: str) -> None:
    assert call(loaded, "dom", "return m.clock(given);", seconds) == shown


@pytest.mark.parametrize(
    ("code", "opened", "status", "reason"),
    [
        (1008, True, 200, "protocol"),
        (1000, True, 200, "stopped"),
        (1001, False, 200, "stopped"),
        (1006, True, 200, "lost"),
        (1006, False, 200, "taken"),
        (1006, False, 403, "link"),
        (1006, True, 0, "lost"),
    ],
)
def test_why_a_connection_ended(loaded: Watched, code: int, opened: bool, status: int, reason: str) -> None:
    body = """
    const [code, opened, status] = given;
    const ask = async () => { if (!status) throw new TypeError("gone"); return { ok: status === 200 }; };
    return m.reason(code, opened, ask);
    """
    assert call(loaded, "connection", body, [code, opened, status]) == reason
