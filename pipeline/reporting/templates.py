"""The page's templates, and how they write numbers."""

from __future__ import annotations

import base64
import hashlib
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from pipeline.reporting import numbers
from pipeline.reporting.factorial_comparison import SYMBOLS, claimed
from pipeline.reporting.results import View, short

TEMPLATES = Path(__file__).parent / "template"


def _angles(view: View) -> str:
    theta, phi = numbers.degrees(view.ranked.theta_deg), numbers.degrees(view.ranked.phi_deg)
    return f"θ = {theta}, φ = {phi}"


def source_hash(style: str) -> str:
    """The style sheet's source in a content-security policy."""
    return "sha256-" + base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()


def environment() -> Environment:
    """What the templates are read with: filters that write numbers, and what they call by name."""
    made = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {
        "metres": numbers.metres,
        "score": numbers.score,
        "cm": numbers.centimetres,
        "at_most": numbers.at_most,
        "percent": numbers.percent,
        "fraction": numbers.fraction,
        "degrees": numbers.degrees,
        "seconds": numbers.seconds,
        "p_value": numbers.p_value,
        "whole": numbers.whole,
        "fixed": numbers.fixed,
        "unbroken": numbers.unbroken,
        "angles": _angles,
        "claimed": claimed,
        "short": short,
    }
    made.globals["symbols"] = SYMBOLS
    made.globals["interval"] = numbers.interval
    return made
