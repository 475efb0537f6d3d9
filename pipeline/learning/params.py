"""The part of params.yaml that every training shares."""

from __future__ import annotations

from pydantic import Field

from pipeline.contract.params import Section


class Schedule(Section):
    """Section ``schedule`` of a network: Adam and its plateau rule (paper, section IV-B)."""

    learning_rate: float = Field(gt=0, le=1)
    halve_after_epochs: int = Field(ge=1, le=10_000)
    stop_after_epochs: int = Field(ge=1, le=10_000)
