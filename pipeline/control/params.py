"""The parts of params.yaml that control reads."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipeline.contract.params import Section

Count = Annotated[int, Field(ge=1, le=10_000)]
Positive = Annotated[float, Field(gt=0, le=1000)]


class SearchParams(Section):
    """The method of CMA-ES.

    ``sigma`` is the first standard deviation in every direction; ``diagonal`` keeps the covariance
    diagonal, which learns faster than a full one where generations are few.
    """

    sigma: Positive
    diagonal: bool


class ControllerParams(SearchParams):
    """Section ``controller``: where CMA-ES starts, and how widely.

    Attributes:
        first: ``rewards`` is the controller of :mod:`pipeline.control.first`; ``zero`` does nothing.
        ridge: of the least squares behind ``rewards``.
        hidden_share: first standard deviation of h's weights, in ``sigma``s. From zero a small one
            pays: h has eight times as many weights as z, and drawn as widely they drown what z says.
    """

    first: Literal["rewards", "zero"]
    ridge: Positive
    hidden_share: Positive


class SearchSizes(Section):
    """Section ``budgets.*.controller``.

    ``episodes`` are those by which each candidate of a generation is evaluated.
    """

    population: Annotated[int, Field(ge=2, le=10_000)]
    episodes: Count
    generations: Count


class EvaluationSizes(Section):
    """Section ``budgets.*.evaluation``: ``episodes`` of each repeat."""

    episodes: Count


class MountingParams(Section):
    """Section ``mounting``: how far off a finalist's camera is tried, without training.

    Attributes:
        turns_deg: of pan and of tilt, each both ways.
        moves_m: to the picture's right, up and back, each both ways.
        episodes: of each repeat.
        repeats: of the finalist, the first ones.
    """

    turns_deg: tuple[Annotated[float, Field(gt=0, le=45)], ...]
    moves_m: tuple[Annotated[float, Field(gt=0, le=1)], ...]
    episodes: Annotated[int, Field(ge=1, le=10_000)]
    repeats: Annotated[int, Field(ge=2, le=40)]
