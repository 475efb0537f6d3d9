"""The tables that the report reads, checked as they are read: metrics of branches, and anchors."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, Field, computed_field

from pipeline.contract.anchors import anchor_warnings
from pipeline.contract.errors import BelvedereError
from pipeline.storage.tables import read_model


class Table(BaseModel):
    """A JSON table as the report reads it; entries that it does not show are skipped."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)


class Anchors(Table):
    """What a return means in a scene, ``reports/anchors/{scene}.json``; returns in metres."""

    no_op_mean: float
    blind_mean: float
    expert_mean: float
    expert_within_2cm_share_mean: float

    def warnings(self, scene: str) -> list[str]:
        """What makes a ranking of the scene's views say little, in sentences."""
        levels = (self.no_op_mean, self.blind_mean, self.expert_mean, self.expert_within_2cm_share_mean)
        return anchor_warnings(scene, *levels)


class OfView(Table):
    """Numbers of a branch, and the viewpoint that they were measured from (angles in degrees)."""

    scene: str = Field(exclude=True)
    theta_deg: float = Field(exclude=True)
    phi_deg: float = Field(exclude=True)


class Vae(OfView):
    """How well a branch's VAE encodes its pictures, ``vae.json``; errors of probes and guesses in metres."""

    reconstruction_error_mean: float
    kl_nats_mean: float
    active_dimensions_mean: float
    probe_linear_tip_m_mean: float
    probe_linear_target_m_mean: float
    probe_linear_tip_to_target_m_mean: float
    probe_mlp_tip_m_mean: float
    probe_mlp_target_m_mean: float
    probe_mlp_tip_to_target_m_mean: float
    guess_tip_m_mean: float
    guess_target_m_mean: float
    guess_tip_to_target_m_mean: float
    target_seen_share_mean: float
    frames_target_hidden_share_mean: float

    @computed_field
    def tip_share(self) -> float | None:
        """The MLP probe's error of the tip as a share of guessing's; ``None`` where a guess cannot err."""
        return _share(self.probe_mlp_tip_m_mean, self.guess_tip_m_mean)

    @computed_field
    def target_share(self) -> float | None:
        """The same of the target."""
        return _share(self.probe_mlp_target_m_mean, self.guess_target_m_mean)

    @computed_field
    def tip_to_target_share(self) -> float | None:
        """The same of the way from one to the other."""
        return _share(self.probe_mlp_tip_to_target_m_mean, self.guess_tip_to_target_m_mean)


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole else None


class Mdnrnn(OfView):
    """How well a branch's second network foresees the next frame, ``mdnrnn.json``; means over latents."""

    heldout_nll_nats_per_latent_mean: float
    heldout_nll_of_last_frame_nats_per_latent_mean: float


class Evaluation(OfView):
    """What a branch's incumbent reached, ``evaluation.json``."""

    final_distance_m_mean: float
    within_2cm_share_mean: float
    within_5cm_share_mean: float


class Operator(OfView):
    """What the scripted operator came to, ``operator.json``.

    Attributes:
        trials, grasped_share: how many, and how many of them ended by closing the gripper.
        time_s_mean, time_s_median: of a trial; the limit where it did not end.
        distance_m_mean, distance_m_median: the task's at the end.
        look_m: by controlled axis, what the view adds to a look (standard deviation, m).
    """

    trials: int
    grasped_share: float
    time_s_mean: float
    time_s_median: float
    distance_m_mean: float
    distance_m_median: float
    look_m: dict[str, float]


ViewT = TypeVar("ViewT", bound=OfView)


def read_of_view(
    table: type[ViewT], path: Path, made_by: str, scene: str, angles_deg: tuple[float, float]
) -> ViewT:
    """Reads one table of a viewpoint, as :func:`pipeline.storage.tables.read_model` does.

    Raises:
        BelvedereError: it is of another viewpoint, besides.
    """
    found = read_model(table, path, made_by)
    if (found.scene, found.theta_deg, found.phi_deg) != (scene, *angles_deg):
        raise BelvedereError(
            f"{path} is of {(found.scene, found.theta_deg, found.phi_deg)}, but the ranking's viewpoint is "
            f"{(scene, *angles_deg)}; run `dvc repro {made_by} ranking@{scene}`."
        )
    return found
