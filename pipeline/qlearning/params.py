"""The parts of params.yaml that Q-learning reads."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.params import MOST_REPEATS, Section

Count = Annotated[int, Field(ge=1, le=10**9)]
Share = Annotated[float, Field(ge=0, le=1)]


class Exploration(Section):
    """Section ``dqn.exploration``: the share of random actions falls from ``first`` to ``last``.

    Attributes:
        first: share at the first frame.
        last: share once ``over`` of all frames are done.
        over: share of the frames.
    """

    first: Share
    last: Share
    over: Annotated[float, Field(gt=0, le=1)]


class DqnParams(Section):
    """Section ``dqn``: the method.

    Attributes:
        scenes: the scenes in which the network is trained.
        learning_rate: Adam's.
        discount: of the next frame's value.
        batch: transitions of a gradient step.
        exploration: random actions.
        worlds: how many act at a time.
    """

    scenes: list[str]
    learning_rate: Annotated[float, Field(gt=0, le=1)]
    discount: Annotated[float, Field(ge=0, lt=1)]
    batch: Annotated[int, Field(ge=1, le=10_000)]
    exploration: Exploration
    worlds: Annotated[int, Field(ge=16, le=10_000)]


class DqnSizes(Section):
    """Section ``budgets.*.dqn``.

    Attributes:
        repeats: independent trainings of every viewpoint; 0 trains none.
        frames: of one training.
        memory: transitions that the replay memory holds.
        frames_per_step: frames seen between two gradient steps.
        target_every: frames between two copies of the network to the target network.
    """

    repeats: Annotated[int, Field(ge=0, le=MOST_REPEATS)]
    frames: Count
    memory: Count
    frames_per_step: Count
    target_every: Count

    @model_validator(mode="after")
    def _memory_holds_a_batch(self) -> DqnSizes:
        if self.memory > self.frames:
            raise ValueError(f"memory {self.memory} is more than the {self.frames} frames there are")
        return self


def dqn_params(scene: str) -> tuple[DqnParams, DqnSizes]:
    """The method, and the chosen budget's sizes in a scene: no repeats where it is none of ``method.scenes``.

    Raises:
        BelvedereError: a value is not valid, or a size not with so many worlds that act at a time.
    """
    method = params.section(DqnParams, "dqn")
    sizes = params.budget_section(DqnSizes, "dqn", scene)
    worlds = method.worlds
    for name in ("frames", "memory", "target_every"):
        if getattr(sizes, name) % worlds:
            raise _does_not_fit(name, sizes, worlds, f"a multiple of {worlds}")
    if worlds % sizes.frames_per_step:
        raise _does_not_fit("frames_per_step", sizes, worlds, f"a divisor of {worlds}")
    return method, sizes if scene in method.scenes else sizes.model_copy(update={"repeats": 0})


def _does_not_fit(name: str, sizes: DqnSizes, worlds: int, valid: str) -> BelvedereError:
    """stable-baselines3 would round the size without a word, as it counts calls, each of all worlds."""
    return BelvedereError(
        f"{params.PARAMS_FILE}: budgets.{params.budget()}.dqn.{name} = {getattr(sizes, name)} is not valid "
        f"where dqn.worlds = {worlds} act at a time: it has to be {valid}."
    )
