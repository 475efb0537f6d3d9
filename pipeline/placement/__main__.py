"""`python -m pipeline.placement --scene NAME`: places the candidates of a scene's search, and says where not.

`./run search NAME` begins with it. Candidates that are there already stay, as long as they are allowed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipeline.contract import params, seeds
from pipeline.contract.errors import BelvedereError, unknown
from pipeline.contract.seeds import Stream
from pipeline.placement.params import PlacementParams
from pipeline.placement.places import Place, allowed_places, spread
from pipeline.placement.screening import Screen
from pipeline.sim.scene import load_scene
from pipeline.storage.candidates import (
    CANDIDATES_FILE,
    Candidate,
    Placed,
    RuledOut,
    read_placed,
    write_placed,
)
from pipeline.storage.stage import entry


def main(*, scene: str, out: Path = CANDIDATES_FILE) -> None:
    """Writes ``out`` with the scene's candidates; other scenes' stay as they are."""
    searches = params.mapping("searches")
    if scene not in searches:
        raise unknown("scene below searches in params.yaml", scene, searches)
    where = params.section(PlacementParams, "searches", scene, "placement")
    former = read_placed(out)
    placed = place(scene, where, former)
    if placed != former:
        write_placed(placed, out)
    taken = [key for key, view in placed.candidates.items() if view.scene == scene]
    fewer = f" ({where.candidates} were asked for)" if len(taken) < where.candidates else ""
    out_of = len(placed.ruled_out[scene])
    print(f"{scene}: {len(taken)} candidates{fewer}, {out_of} places ruled out by geometry")


def place(scene: str, where: PlacementParams, former: Placed) -> Placed:
    """The candidates as declared: those of before that are still allowed, under their names, and new ones.

    Raises:
        BelvedereError: fewer than two places are allowed.
    """
    compiled = load_scene(scene)
    screen = Screen(compiled, where)
    rng = seeds.generator(params.seed(), 0, Stream.CANDIDATES)
    before = {key: view for key, view in former.candidates.items() if view.scene == scene}
    kept = {key: view for key, view in before.items() if screen.within(view) and screen.allowed(_place(view))}
    found = allowed_places(where, compiled.params.camera, where.candidates, screen.allowed, rng)
    named = _named(scene, dict(list(kept.items())[: where.candidates]), found, where.candidates)
    if len(named) < 2:
        reasons = sorted(set(screen.faults.values())) or ["its ranges are one place"]
        raise BelvedereError(
            f"{scene}: geometry leaves {len(named)} place(s) for a camera ({'; '.join(reasons)}); widen "
            f"searches.{scene}.placement in params.yaml."
        )
    others = {key: view for key, view in former.candidates.items() if view.scene != scene}
    out = tuple(RuledOut(**place._asdict(), why=why) for place, why in sorted(screen.faults.items()))
    return Placed(candidates={**others, **named}, ruled_out={**former.ruled_out, scene: out})


def _place(view: Candidate) -> Place:
    return Place(round(view.theta), round(view.phi), view.distance_m, view.fov_deg)


def _named(
    scene: str, kept: dict[str, Candidate], places: Sequence[Place], count: int
) -> dict[str, Candidate]:
    """``kept`` and new ones up to ``count``, which take the lowest numbers that are free."""
    directions = [(round(view.theta), round(view.phi)) for view in kept.values()]
    added = spread(directions, places, count)
    numbers = (n for n in range(1, 10_000) if f"{scene}-c{n:02}" not in kept)
    fresh = {
        f"{scene}-c{number:02}": Candidate(scene=scene, **place._asdict())
        for number, place in zip(numbers, added, strict=False)
    }
    return {**kept, **fresh}


if __name__ == "__main__":
    entry(main)
