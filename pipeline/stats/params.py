"""The ranking's parameters."""

from __future__ import annotations

from pydantic import Field, field_validator

from pipeline.contract.params import Section
from pipeline.stats.tails import TAILS


class RankingParams(Section):
    """Section ``ranking`` of params.yaml, whose entry ``scenes`` may have other values for a scene.

    Attributes:
        confidence: level of the answer and of all intervals; those of :data:`pipeline.stats.tails.TAILS`.
        tolerance: a race ends when its leader is the best or within this of it (score).
        equivalence_margin: differences in score whose 90 % interval lies within ± this are called none.
    """

    confidence: float = Field(gt=0, lt=1)
    tolerance: float = Field(gt=0, le=1)
    equivalence_margin: float = Field(gt=0, le=1)

    @field_validator("confidence")
    @classmethod
    def _known(cls, confidence: float) -> float:
        if confidence not in TAILS:
            raise ValueError(f"the error of a race is known for {', '.join(map(str, TAILS))} only")
        return confidence


class HalvingParams(Section):
    """Section ``searches.SCENE.procedure``.

    Attributes:
        finalists: how many views are raced in the end.
        most_trainings: after which a search ends with the tolerance that was reached; ``None``: only when the
            finalists have the budget's most repeats.
    """

    finalists: int = Field(ge=2, le=20)
    most_trainings: int | None = Field(ge=1, le=1_000_000)
