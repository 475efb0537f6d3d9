"""Matplotlib figures as inline SVG that takes its colours and its type from the page.

Inline, an SVG shares the page's identifiers, its content-security policy and its dark mode. So
style attributes become presentation attributes (the policy allows no inline style), colours become
CSS variables, identifiers that nothing refers to go, and the others are prefixed.
"""

from __future__ import annotations

import html
import io
import re
from typing import Any

import matplotlib

matplotlib.use("svg")

from matplotlib.figure import Figure

# Colours that stand for the CSS variables --plot-{role}; no other colour may be drawn.
ROLES = ("ink", "muted", "grid", "paper", "best", "tied", "worse", "nothing")
COLOURS = {role: f"#0000{index:02x}" for index, role in enumerate(ROLES, start=1)}

RC: Any = {
    "svg.fonttype": "none",
    "svg.hashsalt": "belvedere",
    "font.size": 12,
    "axes.labelsize": 12,
    "xtick.labelsize": 11.5,
    "ytick.labelsize": 11.5,
    "axes.linewidth": 0.8,
    "axes.unicode_minus": True,
    "text.color": COLOURS["ink"],
    "axes.labelcolor": COLOURS["ink"],
    "axes.edgecolor": COLOURS["muted"],
    "xtick.color": COLOURS["muted"],
    "ytick.color": COLOURS["muted"],
    "xtick.labelcolor": COLOURS["ink"],
    "ytick.labelcolor": COLOURS["ink"],
    "grid.color": COLOURS["grid"],
    "grid.linewidth": 0.8,
    "axes.facecolor": "none",
    "figure.facecolor": "none",
}


def inline(figure: Figure, name: str, alt: str) -> str:
    """The figure as an ``<svg>`` element for an HTML body.

    Args:
        figure: drawn, and passed here, under :data:`RC` with :data:`COLOURS` only.
        name: unique on the page; prefixes identifiers.
        alt: what the figure says, for those who cannot see it.
    """
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None})
    text = buffer.getvalue()
    body = text[text.index(">", text.index("<svg")) + 1 : text.rindex("</svg>")]
    body = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>|<!--.*?-->", "", body, flags=re.DOTALL)
    body = re.sub(r' style="([^"]*)"', _presentation, body)
    body = _rename(body.replace("xlink:href", "href"), html.escape(name))
    for role, colour in COLOURS.items():
        body = body.replace(colour, f"var(--plot-{role})")
    body = re.sub(r"\s*\n\s*", "\n", body)
    width, height = (round(inches * 72) for inches in figure.get_size_inches())
    return (
        f'<svg class="plot" role="img" aria-label="{html.escape(alt)}" '
        f'viewBox="0 0 {width} {height}" width="{width}" height="{height}">{body}</svg>'
    )


def _presentation(match: re.Match[str]) -> str:
    """A style attribute as presentation attributes; the font family is the page's."""
    pairs = (part.split(":", 1) for part in html.unescape(match[1]).split(";") if ":" in part)
    return "".join(
        f' {name.strip()}="{value.strip()}"' for name, value in pairs if name.strip() != "font-family"
    )


def _rename(body: str, name: str) -> str:
    """Prefixes the identifiers that are referred to and drops the rest."""
    used = set(re.findall(r'(?:url\(#|href="#)([^)"]+)', body))
    body = re.sub(r' id="([^"]*)"', lambda m: f' id="{name}-{m[1]}"' if m[1] in used else "", body)
    return re.sub(r'(url\(#|href="#)', lambda m: f"{m[1]}{name}-", body)
