"""Numbers as the page writes them."""

from __future__ import annotations

import pytest

from pipeline.reporting import numbers


@pytest.mark.parametrize(
    ("value", "digits", "written"),
    [(-1.005, 1, "−1.0"), (-0.001, 2, "0.00"), (0.0, 0, "0"), (12.345, 2, "12.35"), (None, 2, "–")],
)
def test_fixed(value: float | None, digits: int, written: str) -> None:
    assert numbers.fixed(value, digits) == written


def test_lengths_shares_and_angles_have_their_units() -> None:
    assert numbers.centimetres(0.0234) == "2.3"
    assert numbers.percent(0.456) == "46\u00a0%"
    assert (numbers.degrees(30.0), numbers.degrees(-12.5)) == ("30°", "−12.5°")


def test_half_an_interval_is_none() -> None:
    assert numbers.interval(-1.0, 2.0) == "−1.00 to 2.00"
    assert numbers.interval(-1.0, None) == "–"


def test_seconds_lose_their_decimals_when_long() -> None:
    assert (numbers.seconds(3.14), numbers.seconds(31.4), numbers.seconds(None)) == ("3.1", "31", "–")


@pytest.mark.parametrize(
    ("p", "text"), [(0.0, "< 0.001"), (0.0009, "< 0.001"), (0.001, "0.001"), (0.25, "0.250")]
)
def test_a_p_value_is_never_zero(p: float, text: str) -> None:
    assert numbers.p_value(p) == text


def test_a_bound_is_rounded_up() -> None:
    values = (0.041, 0.04, 0.07, 0.0001, 0.0, None)
    assert [numbers.at_most(value) for value in values] == ["0.05", "0.04", "0.07", "0.01", "0.00", "–"]


def test_counts_and_fractions() -> None:
    assert (numbers.whole(102400.0), numbers.whole(None)) == ("102\u202f400", "–")
    assert (numbers.fraction(0.0213), numbers.fraction(None)) == ("2.1\u00a0%", "–")


def test_angles_and_percentages_stay_in_one_line() -> None:
    assert numbers.unbroken("at (0°, 30°) (95 % sure)") == "at (0°,\u00a030°) (95\u00a0% sure)"
