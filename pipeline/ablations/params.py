"""What params.yaml says of ablations."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pipeline.contract.params import Section

Steps = Annotated[int, Field(ge=1, le=100_000)]


class RewardParams(Section):
    """Section ``ablation.dream.reward``: the network that reads a dream's rewards from z."""

    hidden_units: Annotated[int, Field(ge=1, le=4096)]
    learning_rate: Annotated[float, Field(gt=0, le=1)]
    batch: Annotated[int, Field(ge=1, le=100_000)]
    steps: Steps


class DreamParams(Section):
    """Section ``ablation.dream``: the search in the MDN-RNN's dream.

    Attributes:
        temperature: of the mixtures, as Ha and Schmidhuber (2018) have it; 1 leaves them as they are.
        episodes: by which each candidate of a generation is evaluated.
        generations: of a search.
        reward: what reads rewards from z.
    """

    temperature: Annotated[float, Field(gt=0, le=10)]
    episodes: Annotated[int, Field(ge=1, le=10_000)]
    generations: Annotated[int, Field(ge=1, le=10_000)]
    reward: RewardParams


class AblationParams(Section):
    """Section ``ablation``: ``repeats`` of a viewpoint, the first ones, are tried without a part."""

    repeats: Annotated[int, Field(ge=2, le=40)]
    dream: DreamParams
