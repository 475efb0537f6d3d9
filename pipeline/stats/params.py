"""The ranking's parameters."""

from __future__ import annotations

from pydantic import Field

from pipeline.contract.params import Section


class RankingParams(Section):
    """Section ``ranking`` of params.yaml.

    Attributes:
        confidence: the intervals' confidence level, strictly between 0 and 1.
        equivalence_margin: differences in normalised score whose 90 % interval lies within ± this are
            called none, and the gap that is worth repeats.
    """

    confidence: float = Field(gt=0, lt=1)
    equivalence_margin: float = Field(gt=0)
