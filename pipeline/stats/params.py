"""The ranking's parameters."""

from __future__ import annotations

from pydantic import Field

from pipeline.contract.params import Section


class RankingParams(Section):
    """Section ``ranking`` of params.yaml, whose entry ``scenes`` may have other values for a scene.

    Attributes:
        confidence: level of the answer and of all intervals; those of :data:`pipeline.stats.dunnett.TAILS`.
        tolerance: a race ends when its leader is the best or within this of it (score).
        equivalence_margin: differences in score whose 90 % interval lies within ± this are called none.
    """

    confidence: float = Field(gt=0, lt=1)
    tolerance: float = Field(gt=0)
    equivalence_margin: float = Field(gt=0)
