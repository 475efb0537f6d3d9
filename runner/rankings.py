"""What `./run` reads of a scene's ranking: its answer, and how its race stands."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel, ConfigDict, PositiveInt

from pipeline.storage.tables import read_model

RANKINGS = Path("reports/rankings")


class Part(BaseModel):
    """A part of the JSON; entries that `./run` does not need are ignored."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class Answer(Part):
    """The answer in words: ``sentence``, and ``progress``, a line while the race is on."""

    sentence: str
    progress: str


class Race(Part):
    """How a race stands: whether it is ``open``, repeats that all in it have, and who is in it."""

    open: bool
    common: int
    active: list[str]


class Ranking(Part):
    """A scene's ranking. ``most``: repeats that a view may have."""

    answer: Answer
    race: Race
    most: PositiveInt


def read_ranking(scene: str) -> Ranking:
    """The ranking of a scene.

    Raises:
        BelvedereError: it is missing, or no ranking.
    """
    return read_model(Ranking, RANKINGS / f"{scene}.json", f"ranking@{scene}")
