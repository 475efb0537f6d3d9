"""How numbers are written on the page, and nowhere else decided."""

from __future__ import annotations

import math

MISSING = "–"
_NOISE = 1e-9  # of binary fractions: 0.07 is 7 hundredths


def fixed(value: float | None, digits: int) -> str:
    """``value`` with ``digits`` decimals, a true minus sign and no minus zero; a dash for None."""
    if value is None:
        return MISSING
    text = f"{value:.{digits}f}"
    if float(text) == 0:
        text = text.lstrip("-")
    return text.replace("-", "−")


def metres(value: float | None) -> str:
    """A return or a difference of returns (m, summed over frames)."""
    return fixed(value, 2)


def score(value: float | None) -> str:
    """A score (0 = target-blind, 1 = expert)."""
    return fixed(value, 2)


def at_most(value: float | None) -> str:
    """A score that is a bound from above, so rounded up."""
    return MISSING if value is None else fixed(math.ceil(100 * value - _NOISE) / 100, 2)


def centimetres(value_m: float | None) -> str:
    """A length given in metres, written in centimetres."""
    return fixed(None if value_m is None else 100 * value_m, 1)


def percent(share: float | None) -> str:
    """A share of 1 as a whole percentage."""
    return MISSING if share is None else f"{fixed(100 * share, 0)}\u00a0%"


def fraction(share: float | None) -> str:
    """A share of 1 as a percentage with one decimal."""
    return MISSING if share is None else f"{fixed(100 * share, 1)}\u00a0%"


def degrees(value_deg: float) -> str:
    """An angle, with as many decimals as it has."""
    return f"{value_deg:g}°".replace("-", "−")


def interval(low: float | None, high: float | None) -> str:
    """Both ends of an interval, or a dash where there is none (a single repeat)."""
    return MISSING if low is None or high is None else f"{fixed(low, 2)} to {fixed(high, 2)}"


def p_value(p: float | None) -> str:
    """A p-value: never a zero; a dash for None."""
    if p is None:
        return MISSING
    return "< 0.001" if p < 0.001 else fixed(p, 3)


def seconds(value_s: float | None) -> str:
    """A duration in seconds, whole from 10 s up."""
    return MISSING if value_s is None else fixed(value_s, 0 if value_s >= 10 else 1)


def whole(value: float | None) -> str:
    """A count, thousands apart."""
    return MISSING if value is None else f"{value:,.0f}".replace(",", "\u202f")


def unbroken(sentence: str) -> str:
    """A sentence whose angles and percentages stay in one line."""
    return sentence.replace(" %", "\u00a0%").replace("°, ", "°,\u00a0")
