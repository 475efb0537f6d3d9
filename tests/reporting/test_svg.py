"""Figures as inline SVG."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree

import matplotlib
from matplotlib.figure import Figure

from pipeline.reporting.svg import COLOURS, RC, inline


def _drawn(name: str, alt: str = "a line") -> str:
    with matplotlib.rc_context(RC):
        figure = Figure(figsize=(3, 2))
        axes = figure.subplots()
        axes.plot([0, 1], [0, 1], "o-", color=COLOURS["best"])
        axes.fill_between([0, 1], [0, 0], [1, 1], color=COLOURS["worse"], alpha=0.2)
        axes.set_xlabel("x & y")
        return inline(figure, name, alt)


def test_well_formed_and_loads_nothing() -> None:
    svg = _drawn("one", 'says "5 < 6"')
    root = ElementTree.fromstring(svg)
    assert root.attrib["aria-label"] == 'says "5 < 6"'
    assert root.attrib["viewBox"] == "0 0 216 144"
    assert "http" not in svg and "style" not in svg and "font-family" not in svg


def test_colours_are_the_pages() -> None:
    svg = _drawn("one")
    assert {"var(--plot-best)", "var(--plot-worse)", "var(--plot-ink)"} <= set(
        re.findall(r"var\([^)]*\)", svg)
    )
    assert not re.search(r"#[0-9a-f]{6}\b", svg)


def test_two_figures_share_no_identifier_and_refer_to_their_own() -> None:
    found = {}
    for name in ("one", "two"):
        svg = _drawn(name)
        found[name] = set(re.findall(r' id="([^"]+)"', svg))
        assert set(re.findall(r'(?:url\(#|href="#)([^)"]+)', svg)) == found[name] != set()
    assert not found["one"] & found["two"]


def test_a_name_makes_no_element() -> None:
    svg = _drawn('x"><img src=x onerror="y')
    assert "img" not in {element.tag for element in ElementTree.fromstring(svg).iter()}


def test_same_figure_gives_the_same_bytes() -> None:
    assert _drawn("one") == _drawn("one")
