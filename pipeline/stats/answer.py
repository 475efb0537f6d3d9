"""Where the camera should stand: what a race and its table of views come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from pipeline.stats.ranks import AS_GOOD, LEADER, Ranked
from pipeline.stats.replay import Race

Kind = Literal["alone", "tolerance", "either", "ended", "open", "cannot see", "not above blind"]
VIEW = "view"
SURE_FROM = 10  # repeats from which a race with failed trainings may state its confidence


@dataclass(frozen=True)
class Answer:
    """What is known of a scene, without words.

    Attributes:
        scene: its name.
        kind: ``alone`` (one view is left), ``tolerance`` (the leader is the best or near enough), ``either``
            (the same of both views that are left), ``ended`` (all repeats are spent), ``open`` (more are
            needed), ``cannot see`` (the judge, at no view) or ``not above blind`` (no view was learned from).
        confidence: of what it says.
        tolerance: U at which a race ends (score).
        repeats, most: that the race has looked at, and the most it may have.
        rows: the scene's table.
        within: U: the leader is the best or within this of it (score).
        lead, lead_high: by how much it is ahead of the next, and the most it may be; both views' scores.
        forecast: about how many more trainings bring U to the tolerance.
        sure: whether the confidence may be stated: not where a training failed and few are there.
        noun: what is compared: views, or a search's finalists.
    """

    scene: str
    kind: Kind
    confidence: float
    tolerance: float
    repeats: int
    most: int
    rows: list[Ranked]
    within: float | None
    lead: float | None
    lead_high: float | None
    forecast: int | None
    sure: bool
    noun: str = VIEW

    def of(self, *states: str) -> list[Ranked]:
        """The views in these states, best first."""
        return [row for row in self.rows if row.state in states]

    @property
    def keys(self) -> list[str]:
        """The leader, then those that may be as good; none where nothing can be chosen."""
        if self.kind in ("cannot see", "not above blind"):
            return []
        return [row.key for row in self.of(LEADER, AS_GOOD)]


def answer(
    scene: str,
    race: Race | None,
    rows: list[Ranked],
    confidence: float,
    race_scores: Sequence[np.ndarray],
    noun: str = "view",
) -> Answer:
    """The answer of a scene.

    Args:
        scene: its name.
        race: of the views at which the judge sees; ``None`` where there is none.
        rows: the table of all views.
        confidence: of the race.
        race_scores: of each view in the race (repeat,) its scores.
        noun: what is compared.
    """
    if race is None:
        return Answer(scene, "cannot see", confidence, 0.0, 0, 0, rows, None, None, None, None, False)
    kind, at = _kind(race, rows), race.last.repeats
    return Answer(
        scene,
        kind,
        confidence,
        race.rules.tolerance,
        at,
        race.rules.most,
        rows,
        float(race.last.within),
        *race.lead(),
        forecast=race.forecast() if kind in ("open", "ended") else None,
        sure=at >= SURE_FROM or not any((own[:at] <= 0).any() for own in race_scores),
        noun=noun,
    )


def _kind(race: Race, rows: Sequence[Ranked]) -> Kind:
    if race.state == "open":
        return "open"
    left = [row for row in rows if row.state in (LEADER, AS_GOOD)]
    if not any(row.score_low is not None and row.score_low > 0 for row in left):
        return "not above blind"
    if race.state == "tolerance" and len(left) == 2:
        first, second = race.active
        last = race.last
        worst = last.means[first] - last.means[second] + last.half_widths[first, second]  # U of the second
        if worst <= race.rules.tolerance:
            return "either"
    return race.state


def race_part(race: Race | None, names: Sequence[str]) -> Mapping[str, Any]:
    """The race as a plain table; ``names`` are its views'."""
    if race is None:
        nothing = dict.fromkeys(("leader", "lead_low", "lead_high"))
        return {"open": False, "common": 0, "active": [], "out": {}, **nothing, "looks": []}
    looks = [
        {
            "repeats": look.repeats,
            "leader": names[int(look.leader)],
            "within": float(look.within),
            "active": [name for name, left in zip(names, look.active, strict=True) if left],
        }
        for look in race.looks
    ]
    return {
        "open": race.state == "open",
        "common": race.last.repeats,
        "active": [names[view] for view in race.active],
        "out": {names[view]: repeats for view, repeats in race.out.items()},
        "leader": names[race.leader],
        "lead_low": -float(race.last.within),
        "lead_high": race.lead()[1],
        "looks": looks,
    }
