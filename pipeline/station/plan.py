"""In which order a participant sees tasks and views: counterbalanced over the study, drawn from a seed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from pydantic import AwareDatetime, Field

from pipeline.contract.params import Section
from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene
from pipeline.station.params import StationParams
from pipeline.study.records import Count, Number, Operator, Place

_STREAM = 100  # of the seeds that DVC's stages do not use
_PRACTICE = 101

Order = tuple[str, ...]


class PlannedTrial(Section):
    """A trial: where the tip starts and where the target stands, m; ``trial`` counts over the session."""

    trial: Number
    target_index: Count
    start_m: Place
    target_m: Place


class Block(Section):
    """Trials of one scene, seen from one view."""

    block: Number
    scene: str
    view: str
    theta: float
    phi: float
    trials: Annotated[tuple[PlannedTrial, ...], Field(min_length=1)]

    @property
    def viewpoint(self) -> Viewpoint:
        """Where the camera stands."""
        return Viewpoint(scene=self.scene, theta=self.theta, phi=self.phi)


class Consent(Section):
    """Which text was agreed to, and when."""

    version: str
    sha256: str
    accepted_at: AwareDatetime


class DrawnBy(Section):
    """What draws the live picture in the whole session."""

    name: str
    size: tuple[Number, Number]
    samples: Count


class Plan(Section):
    """A session: all that is known of it before its first trial.

    Attributes:
        participant, session, operator: whose.
        seed: of every draw.
        number: how many plans the study held before it; part of the seed.
        created: when.
        provenance: revision, versions, machine.
        params: section ``station``.
        scenes: a hash of each scene, so that a session is not resumed on another one.
        renderer: what draws its pictures.
        consent: None for the scripted operator.
        blocks: in order.
    """

    participant: str
    session: Number
    operator: Operator
    seed: Count
    number: Count
    created: AwareDatetime
    provenance: dict[str, Any]
    params: StationParams
    scenes: dict[str, str]
    renderer: DrawnBy
    consent: Consent | None
    blocks: Annotated[tuple[Block, ...], Field(min_length=1)]


def orders(names: Sequence[str]) -> list[Order]:
    """Orders of a Williams design: each name stands equally often at each place and before each other name.

    Args:
        names: n different ones.

    Returns:
        n orders for an even n, 2 n for an odd one above 1.
    """
    n = len(names)
    first = [0, *((step + 1) // 2 if step % 2 else n - step // 2 for step in range(1, n))]
    rows = [[(place + shift) % n for place in first] for shift in range(n)]
    rows += [row[::-1] for row in rows] if n % 2 and n > 1 else []
    return [tuple(names[place] for place in row) for row in rows]


def least_used(choices: Sequence[Order], used: Sequence[Order], rng: np.random.Generator) -> Order:
    """One of the orders that were used least, drawn."""
    counts = Counter(used)
    fewest = min(counts[choice] for choice in choices)
    rarest = [choice for choice in choices if counts[choice] == fewest]
    return rarest[int(rng.integers(len(rarest)))]


def task_order(blocks: Sequence[Block]) -> Order:
    """The order of a plan's scenes."""
    return tuple(dict.fromkeys(block.scene for block in blocks))


def view_order(blocks: Sequence[Block], scene: str) -> Order:
    """The order of a plan's views of a scene."""
    return tuple(block.view for block in blocks if block.scene == scene)


def planned_blocks(
    scenes: dict[str, Scene],
    views: dict[str, dict[str, Viewpoint]],
    earlier: Sequence[Sequence[Block]],
    trials: int,
    rng: np.random.Generator,
) -> tuple[Block, ...]:
    """A session's blocks.

    The order of tasks, and in each task that of its views, is one of a Williams design that earlier
    participants had least; what is left open is drawn. All views of a task have the same starts and targets,
    in an order of their own.

    Args:
        scenes: by name.
        views: the compared viewpoints by scene and name.
        earlier: the blocks of earlier participants.
        trials: of a block.
        rng: of this participant.
    """
    had = [blocks for blocks in earlier if set(task_order(blocks)) == set(scenes)]
    order = least_used(orders(list(scenes)), [task_order(blocks) for blocks in had], rng)
    blocks: list[Block] = []
    for name in order:
        places = _places(scenes[name], trials, rng)
        seen = [view_order(b, name) for b in earlier if set(view_order(b, name)) == set(views[name])]
        for view in least_used(orders(list(views[name])), seen, rng):
            at = views[name][view]
            first = 1 + trials * len(blocks)
            numbered = [
                PlannedTrial(trial=first + i, **places[k]) for i, k in enumerate(rng.permutation(trials))
            ]
            block = Block(
                block=len(blocks) + 1,
                scene=name,
                view=view,
                theta=at.theta,
                phi=at.phi,
                trials=tuple(numbered),
            )
            blocks.append(block)
    return tuple(blocks)


def _places(scene: Scene, count: int, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Starts and targets as the model's episodes have them, by target; an index tells them apart.

    The index is that of the target's candidate where no candidate comes twice, else it counts.
    """
    drawn = draw_episodes(scene, count, rng)
    candidates = np.asarray(scene.params.target.candidates_m)
    nearest = np.linalg.norm(drawn.target_m[:, None] - candidates[None], axis=2).argmin(axis=1)
    order = np.argsort(nearest, kind="stable")
    once = len(set(nearest.tolist())) == count
    return [
        {
            "target_index": int(nearest[k]) if once else i,
            "start_m": tuple(map(float, drawn.start_m[k])),
            "target_m": tuple(map(float, drawn.target_m[k])),
        }
        for i, k in enumerate(order)
    ]


def generator(seed: int, number: int, practice: bool = False) -> np.random.Generator:
    """The generator of a study's ``number``-th participant, of the plan or of practice."""
    key = (_PRACTICE if practice else _STREAM, number)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(entropy=seed, spawn_key=key)))
