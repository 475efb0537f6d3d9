"""A map of the sphere from above: pan around, the zenith in the middle, the horizon on the rim."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
import polars as pl

from pipeline.reporting import numbers
from pipeline.reporting.results import short
from pipeline.reporting.search_tables import Candidate, Search
from pipeline.reporting.svg import COLOURS, RC, inline
from pipeline.stats.tried import Tried

from matplotlib.axes import Axes  # isort: skip  (after svg, which chooses the backend)
from matplotlib.figure import Figure  # isort: skip

SIZE_IN = (5.8, 5.4)
LEVELS = 7  # of the surface's shades
FAINTEST, STRONGEST = 0.06, 0.62  # opacity of the lowest and of the highest shade
BLANK_SHARE = 0.5  # of the map's range: where the surface's deviation is larger it is not drawn
FADE = 4  # steps in which the paper covers what is uncertain
_AREA = 34.0  # of a dot of one repeat, square points


@matplotlib.rc_context(RC)
def sphere_plot(search: Search, surface: pl.DataFrame, tried: Sequence[Tried]) -> str:
    """Dots where trainings were, sized by repeats; finalists ringed; the surface for the eye alone."""
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    axes = figure.subplots()
    axes.set_aspect("equal")
    axes.set_axis_off()
    _rim(axes)
    shaded = _surface(axes, surface)
    for place in search.ruled_out:
        axes.scatter(*on_map(place.theta, place.phi), 26, marker="x", color=COLOURS["nothing"], linewidth=0.9)
    for key, one in search.candidates.items():
        _dot(axes, search, key, one)
    for row in tried:
        at = on_map(row.spot.theta_deg, row.spot.phi_deg)
        axes.scatter(*at, 46, marker="D", facecolor="none", edgecolor=COLOURS["worse"], linewidth=1.3)
    said = [
        f"{short(row.key, search.scene)} ({numbers.degrees(row.theta_deg)}, {numbers.degrees(row.phi_deg)}) "
        f"{numbers.score(row.score_mean)}"
        for row in search.viewpoints
    ]
    alt = (
        f"Candidates of {search.scene} on the sphere, from above. Finalists: {'; '.join(said) or 'none yet'}."
    )
    return inline(figure, f"sphere-{search.scene}", alt + (f" Surface: {shaded}." if shaded else ""))


def on_map(theta_deg: np.ndarray | float, phi_deg: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    """Where a direction is: the radius is 90° − φ, θ = 0° points down and 90° to the right.

    Below the horizon the map goes on beyond the rim.
    """
    angle, radius = np.radians(theta_deg), 90.0 - np.asarray(phi_deg, dtype=float)
    return radius * np.sin(angle), -radius * np.cos(angle)


def _rim(axes: Axes) -> None:
    around = np.linspace(0, 360, 181)
    for phi in (0, 30, 60):
        axes.plot(*on_map(around, phi), color=COLOURS["grid"], linewidth=0.9, zorder=0)
        axes.annotate(f"{phi}°", on_map(180, phi), ha="center", va="center", color=COLOURS["muted"])
    for theta in range(0, 360, 45):
        ends = np.array([on_map(theta, 80), on_map(theta, 0)]).T
        axes.plot(*ends, color=COLOURS["grid"], linewidth=0.9, zorder=0)
    for theta, name in ((0, "front, 0°"), (90, "90°"), (-90, "−90°")):
        axes.annotate(name, on_map(theta, -9), ha="center", va="center", color=COLOURS["muted"])


def _surface(axes: Axes, surface: pl.DataFrame) -> str:
    """Draws the surface where its deviation allows; says its range."""
    if surface.is_empty():
        return ""
    pans, tilts = (surface[name].unique().sort().to_numpy() for name in ("theta_deg", "phi_deg"))
    if len(pans) < 2 or len(tilts) < 2:
        return ""
    ordered = surface.sort("phi_deg", "theta_deg")
    mean, sd = (ordered[name].to_numpy().reshape(len(tilts), len(pans)) for name in ("mean", "sd"))
    x, y = on_map(*np.meshgrid(pans, tilts))
    low, high = float(mean.min()), float(mean.max())
    if high - low < 1e-6:
        return ""
    unsure = sd / (BLANK_SHARE * (high - low))
    shown = np.ma.masked_where(unsure >= 1.0, mean)
    if shown.count() == 0:
        return ""
    edges = np.linspace(low, high, LEVELS + 1)
    opacity = np.linspace(FAINTEST, STRONGEST, LEVELS)
    shades = [matplotlib.colors.to_rgba(COLOURS["best"], alpha) for alpha in opacity]
    axes.contourf(x, y, shown, levels=edges, colors=shades, zorder=1)
    covers = [matplotlib.colors.to_rgba(COLOURS["paper"], 0.2 * step) for step in range(1, FADE + 1)]
    axes.contourf(x, y, unsure, levels=np.linspace(0.5, 1.0, FADE + 1), colors=covers, zorder=2)
    return f"{numbers.score(low)} to {numbers.score(high)}"


def _dot(axes: Axes, search: Search, key: str, one: Candidate) -> None:
    at, area = on_map(one.theta_deg, one.phi_deg), _AREA * max(one.repeats, 1) ** 0.5
    if one.state == "cannot see":
        axes.scatter(*at, area, marker="x", color=COLOURS["worse"], linewidth=1.4, zorder=4)
        return
    filled = COLOURS["ink"] if one.repeats else "none"
    axes.scatter(*at, area, facecolor=filled, edgecolor=COLOURS["ink"], linewidth=1.0, zorder=4)
    if key not in search.finalists:
        return
    place = {row.key: row.state for row in search.viewpoints}
    inside = place.get(key, "leader") in ("leader", "may be as good")
    ring = COLOURS["best"] if inside else COLOURS["muted"]
    axes.scatter(
        *at, area + 130, facecolor="none", edgecolor=ring, linewidth=2.4 if inside else 1.2, zorder=5
    )
    axes.annotate(
        short(key, search.scene),
        at,
        xytext=(9, 7),
        textcoords="offset points",
        color=COLOURS["ink"],
        zorder=6,
    )
