"""What is asked of a study with people."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator

from pipeline.contract.params import Section
from pipeline.study.records import Outcome

FOLDER = r"^[A-Za-z0-9_][A-Za-z0-9_-]*(/[A-Za-z0-9_][A-Za-z0-9_.-]*)*$"
Probability = Annotated[float, Field(gt=0, lt=1)]


class ExcludeParams(Section):
    """Section ``people.exclude``: which ended attempts do not count; each is listed with its reason.

    Attributes:
        p95_latency_ms: above this the picture came too late.
        real_time_factor: below this the simulation was slower than the clock.
        least_time_s: a trial that took less was no attempt to reach.
        outcomes: that do not count.
    """

    p95_latency_ms: Annotated[float, Field(gt=0, le=60_000)]
    real_time_factor: Annotated[float, Field(gt=0, le=1)]
    least_time_s: Annotated[float, Field(ge=0, le=3600)]
    outcomes: tuple[Outcome, ...]

    @field_validator("outcomes")
    @classmethod
    def _some_count(cls, outcomes: tuple[Outcome, ...]) -> tuple[Outcome, ...]:
        if not {"timeout", "aborted"} <= set(outcomes):
            raise ValueError(
                "timeout and aborted must stand in it: such attempts have no time and no distance"
            )
        if "grasped" in outcomes:
            raise ValueError("grasped must not stand in it: nothing would be left")
        return outcomes


class PeopleParams(Section):
    """Section ``people``.

    Attributes:
        study: the study's folder, from the repository's root; it stands in a command, so it has no spaces.
        exclude: which attempts do not count.
        alpha: level of tests; intervals have 1 − alpha.
        power: with which the next study is to find a difference.
    """

    study: Annotated[str, Field(pattern=FOLDER)]
    exclude: ExcludeParams
    alpha: Probability
    power: Probability
