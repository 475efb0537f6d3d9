"""The paper's findings held against ours: which way a difference goes, whether it matters, and what follows.

A direction is settled where the interval lies on one side of zero; a size is below the margin where the 90 %
interval lies within it. A settled opposite direction contradicts a claim that one level is higher; a claim of
no effect is contradicted only by an interval wholly beyond the margin.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import yaml
from pydantic import TypeAdapter, ValidationError

from pipeline.contract.errors import BelvedereError
from pipeline.contract.params import Section
from pipeline.stats.factorial import NOT_SETTLED
from pipeline.stats.ranks import UNSEEING
from pipeline.stats.steps import Step

AGREES = "agrees"
CONTRADICTS = "contradicts"
NOT_ABOVE_BLIND = "not above blind"
NOT_RUN = "not run"
SAME, OPPOSITE = "same", "opposite"
LEANS_SAME, LEANS_OPPOSITE = "not settled, leans the same way", "not settled, leans the other way"
MAY_MATTER = "may matter"


class Claim(Section):
    """One finding of the paper.

    Attributes:
        section: of the paper.
        scene: our scene for it.
        judge: ``world model``, ``dqn``, or the one over the other (their interaction).
        factor: ``theta`` or ``phi``.
        first_deg, second_deg: the levels compared; without them all pairs are meant.
        finding: ``higher`` (the first of two levels) or ``none`` (no difference).
    """

    section: str
    scene: str
    judge: Literal["world model", "dqn", "world model over dqn"]
    factor: Literal["theta", "phi"]
    first_deg: float | None = None
    second_deg: float | None = None
    finding: Literal["higher", "none"]


class Held(Claim):
    """A claim beside our results.

    Attributes:
        difference, low, high: of the first level less the second, in normalised score, if one step decides.
        direction: ``same``, ``opposite``, or ``not settled`` with the way it leans; ``None`` where the claim
            has none (no effect) or nothing was found.
        size: ``below`` the margin or ``may matter``; ``None`` where nothing was found or no margin is fixed.
        outcome: ``agrees``, ``contradicts``, ``not settled``, ``cannot see``, ``not above blind`` or
            ``not run``.
    """

    difference: float | None = None
    low: float | None = None
    high: float | None = None
    direction: str | None = None
    size: str | None = None
    outcome: str


@dataclass(frozen=True)
class Judgement:
    """What a judge found.

    Attributes:
        steps: between levels.
        margin: differences in score within ± this are called none.
        above_blind: whether it had learned anything: some view above target-blind.
        unseen: (θ, φ) in degrees of views behind the steps at which the judge cannot see.
    """

    steps: Sequence[Step]
    margin: float
    above_blind: bool = True
    unseen: Sequence[tuple[float, float]] = ()


def read_claims(path: Path) -> list[Claim]:
    """The claims in a YAML file.

    Raises:
        BelvedereError: the file is missing, or an entry is not valid.
    """
    try:
        return TypeAdapter(list[Claim]).validate_python(yaml.safe_load(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise BelvedereError(
            f"{path} is missing; it is part of the repository: `git checkout {path}`."
        ) from None
    except (yaml.YAMLError, UnicodeDecodeError, ValidationError) as error:
        reason = error.errors()[0] if isinstance(error, ValidationError) else error
        raise BelvedereError(
            f"{path} holds no list of claims: {' '.join(str(reason).split())[:200]}."
        ) from None


def held(claims: Sequence[Claim], judges: Mapping[str, Judgement]) -> list[Held]:
    """Each claim with its outcome.

    Args:
        claims: of one scene.
        judges: what each found, by the claims' names; those that did not run are absent.
    """
    return [_held(claim, judges.get(claim.judge)) for claim in claims]


def _held(claim: Claim, judgement: Judgement | None) -> Held:
    steps = _steps(claim, judgement.steps if judgement else ())
    if judgement is None or not steps:
        return Held(**claim.model_dump(), outcome=NOT_RUN)
    shown: dict[str, Any] = {}
    if len(steps) == 1:
        shown = {name: getattr(steps[0], name) for name in ("difference", "low", "high")}
    if _concerned(claim, judgement.unseen):
        return Held(**claim.model_dump(), **shown, outcome=UNSEEING)
    if not judgement.above_blind:
        return Held(**claim.model_dump(), **shown, outcome=NOT_ABOVE_BLIND)
    direction = _direction(steps[0]) if claim.finding == "higher" else None
    return Held(
        **claim.model_dump(),
        **shown,
        direction=direction,
        size=_size(steps, judgement.margin),
        outcome=_of_direction(direction) if direction else _of_no_effect(steps, judgement.margin),
    )


def _steps(claim: Claim, steps: Sequence[Step]) -> list[Step]:
    """The steps that the claim speaks of, turned its way."""
    of_factor = [step for step in steps if step.factor == claim.factor]
    if claim.first_deg is None:
        return of_factor
    wanted = (claim.first_deg, claim.second_deg)
    both_ways = [way for step in of_factor for way in (step, step.turned())]
    return [way for way in both_ways if (way.first_deg, way.second_deg) == wanted]


def _concerned(claim: Claim, unseen: Sequence[tuple[float, float]]) -> bool:
    """Whether the claim rests on one of these views."""
    levels = {place[claim.factor == "phi"] for place in unseen}
    return bool(levels if claim.first_deg is None else levels & {claim.first_deg, claim.second_deg})


def _direction(step: Step) -> str:
    if step.low > 0:
        return SAME
    if step.high < 0:
        return OPPOSITE
    return LEANS_SAME if step.difference > 0 else LEANS_OPPOSITE


def _of_direction(direction: str) -> str:
    return {SAME: AGREES, OPPOSITE: CONTRADICTS}.get(direction, NOT_SETTLED)


def _size(steps: Sequence[Step], margin: float) -> str | None:
    if any(step.narrow_low is None for step in steps):
        return None
    return f"below {margin:g}" if all(step.below(margin) for step in steps) else MAY_MATTER


def _of_no_effect(steps: Sequence[Step], margin: float) -> str:
    if any(step.beyond(margin) for step in steps):
        return CONTRADICTS
    return AGREES if all(step.below(margin) for step in steps) else NOT_SETTLED
