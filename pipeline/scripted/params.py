"""The scripted operator's parameters."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pipeline.contract.params import Section

Seconds = Annotated[float, Field(gt=0, le=10)]


class OperatorParams(Section):
    """Section ``operator``: proportional control after looks that err.

    Attributes:
        gain_per_s: commanded speed per distance still to go.
        noise_m: standard deviation of a look on each axis, whatever the view.
        look_s: between one look and the next; in between it goes by the last one.
        reaction_s: from a look to the motion that it causes.
        speed_m_s: the largest speed that it commands.
        grasp_within_m: it closes the gripper once it believes to be this near for ``dwell_s``.
        dwell_s: see there.
        limit_s: a trial that lasts longer has failed.
        picture_px: height of the picture in which it sees.
        blur_px: standard deviation with which it places an edge in that picture, on each axis.
        trials: of each target position, in the stage ``operator``.
    """

    gain_per_s: Annotated[float, Field(gt=0, le=20)]
    noise_m: Annotated[float, Field(ge=0, le=0.2)]
    look_s: Seconds
    reaction_s: Annotated[float, Field(ge=0, le=2)]
    speed_m_s: Annotated[float, Field(gt=0, le=2)]
    grasp_within_m: Annotated[float, Field(gt=0, le=0.2)]
    dwell_s: Seconds
    limit_s: Annotated[float, Field(gt=0, le=3600)]
    picture_px: Annotated[int, Field(ge=16, le=4096)]
    blur_px: Annotated[float, Field(ge=0, le=64)]
    trials: Annotated[int, Field(ge=2, le=10_000)]
