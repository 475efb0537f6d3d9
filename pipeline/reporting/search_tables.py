"""A search over the sphere as the report reads it."""

from __future__ import annotations

from pipeline.reporting.rankings import Kind, RankedView
from pipeline.reporting.tables import Table


class Found(Table):
    """A search's answer among its finalists; as :class:`pipeline.reporting.rankings.Answer`."""

    kind: Kind
    keys: list[str]
    within: float | None
    sure: bool
    forecast_trainings: int | None
    sentence: str


class Candidate(Table):
    """One candidate; angles in degrees, scores over all its repeats."""

    theta_deg: float
    phi_deg: float
    distance_m: float
    fov_deg: float
    repeats: int
    score_mean: float | None
    score_low: float | None
    score_high: float | None
    state: str
    dropped_after: int | None
    misses: str


class Finalist(RankedView):
    """A finalist's line, of the repeats that were made after it was chosen."""

    key: str


class RuledOut(Table):
    """A place that geometry rules out, degrees, and why."""

    theta: float
    phi: float
    distance_m: float
    fov_deg: float
    why: str


class Search(Table):
    """A scene's search, ``reports/searches/SCENE.json``."""

    scene: str
    confidence: float
    tolerance: float
    budget: str
    seed: int
    answer: Found | None
    progress: str
    open: bool
    trainings: int
    finalists: list[str]
    candidates: dict[str, Candidate]
    viewpoints: list[Finalist]
    ruled_out: list[RuledOut]

    @property
    def cameras_differ(self) -> bool:
        """Whether candidates have distances or fields of view of their own."""
        return len({(one.distance_m, one.fov_deg) for one in self.candidates.values()}) > 1

    @property
    def reasons(self) -> dict[str, int]:
        """Why places were ruled out, and how many for each reason."""
        whys = [one.why for one in self.ruled_out]
        return {why: whys.count(why) for why in sorted(set(whys))}

    @property
    def ordered(self) -> dict[str, Candidate]:
        """The candidates, those that stayed longest first, and of them the highest scores."""
        last = {key: (-one.repeats, -(one.score_mean or 0.0)) for key, one in self.candidates.items()}
        places = {key: place for place, key in enumerate(row.key for row in self.viewpoints)}
        return {
            key: self.candidates[key]
            for key in sorted(last, key=lambda key: (places.get(key, len(last)), *last[key]))
        }


class Off(Table):
    """A finalist's change in score with its camera at an offset: turned by degrees or moved by metres."""

    theta_deg: float
    phi_deg: float
    right_m: float
    up_m: float
    back_m: float
    turn_deg: float
    move_m: float
    change: float
    low: float | None
    high: float | None


class Mounting(Table):
    """What a finalist loses off its place, ``mounting/KEY.json`` beside the search; angles in degrees."""

    theta_deg: float
    phi_deg: float
    repeats: int
    offsets: list[Off]

    @property
    def turns(self) -> dict[float, Off]:
        """By each turn, degrees, the worst of the directions."""
        return _worst({off.turn_deg: [] for off in self.offsets if off.turn_deg}, self.offsets, "turn_deg")

    @property
    def moves(self) -> dict[float, Off]:
        """By each move, m, the worst of the directions."""
        return _worst({off.move_m: [] for off in self.offsets if off.move_m}, self.offsets, "move_m")


def _worst(by_size: dict[float, list[Off]], offsets: list[Off], name: str) -> dict[float, Off]:
    for off in offsets:
        if getattr(off, name):
            by_size[getattr(off, name)].append(off)
    return {size: min(found, key=lambda off: off.change) for size, found in sorted(by_size.items())}
