"""The paper's findings held against ours: each agrees, contradicts, or cannot be told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import yaml
from pydantic import TypeAdapter, ValidationError

from pipeline.contract.errors import BelvedereError
from pipeline.contract.params import Section
from pipeline.stats.factorial import DIFFERS, NO_DIFFERENCE, NOT_SEPARATED, Difference
from pipeline.stats.ranks import NOT_ABOVE_BLIND

AGREES = "agrees"
CONTRADICTS = "contradicts"
NOT_RUN = "not run"


class Claim(Section):
    """One finding of the paper.

    Attributes:
        section: of the paper.
        scene: our scene for it.
        judge: ``world model``, ``dqn``, or the one over the other (their interaction).
        factor: ``theta`` or ``phi``.
        first_deg, second_deg: the levels compared; without them all pairs are meant.
        finding: ``higher`` (the first level) or ``none`` (no difference).
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
        outcome: ``agrees``, ``contradicts``, ``not separated``, ``not above blind`` or ``not run``.
    """

    difference: float | None = None
    low: float | None = None
    high: float | None = None
    outcome: str


@dataclass(frozen=True)
class Step(Difference):
    """In normalised score, as a judge found it.

    Attributes:
        word: what it is, see :func:`pipeline.stats.factorial.word`.
    """

    word: str

    def turned(self) -> Step:
        """The same, second level less first."""
        return replace(
            self,
            first_deg=self.second_deg,
            second_deg=self.first_deg,
            difference=-self.difference,
            low=-self.high,
            high=-self.low,
        )


@dataclass(frozen=True)
class Judgement:
    """What a judge found: its steps, and whether it had learned anything (some view above blind)."""

    steps: Sequence[Step]
    above_blind: bool = True


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
    except (yaml.YAMLError, ValidationError) as error:
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
    shown = {}
    if len(steps) == 1:
        shown = {name: getattr(steps[0], name) for name in ("difference", "low", "high")}
    return Held(**claim.model_dump(), **shown, outcome=_outcome(claim, judgement, steps))


def _steps(claim: Claim, steps: Sequence[Step]) -> list[Step]:
    """The steps that the claim speaks of, turned its way."""
    of_factor = [step for step in steps if step.factor == claim.factor]
    if claim.first_deg is None:
        return of_factor
    wanted = (claim.first_deg, claim.second_deg)
    both_ways = [way for step in of_factor for way in (step, step.turned())]
    return [way for way in both_ways if (way.first_deg, way.second_deg) == wanted]


def _outcome(claim: Claim, judgement: Judgement | None, steps: Sequence[Step]) -> str:
    if judgement is None or not steps:
        return NOT_RUN
    if not judgement.above_blind:
        return NOT_ABOVE_BLIND
    if claim.finding == "none":
        if any(step.word == DIFFERS for step in steps):
            return CONTRADICTS
        return AGREES if all(step.word == NO_DIFFERENCE for step in steps) else NOT_SEPARATED
    if all(step.low > 0 for step in steps):
        return AGREES
    against = any(step.high < 0 or step.word == NO_DIFFERENCE for step in steps)
    return CONTRADICTS if against else NOT_SEPARATED
