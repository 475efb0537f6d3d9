"""The tables that the report reads: rankings, anchors and metrics of branches, checked as they are read.

What a statistic returns is read back as what it was.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from pipeline.contract.artefacts import read_json
from pipeline.contract.errors import BelvedereError
from pipeline.stats import alignment as people
from pipeline.stats.baselines import Compared
from pipeline.stats.claims import Held
from pipeline.stats.factorial import Factorial, FTest
from pipeline.stats.judges import EffectByJudge
from pipeline.stats.pairs import Gap, Pair


class Table(BaseModel):
    """A JSON table as the report reads it; entries that it does not show are passed over."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)


TableT = TypeVar("TableT", bound=Table)
Verdict = Literal["best", "not separated", "worse", "not above blind"]


class Ranked(Table):
    """One viewpoint's row of a ranking; returns in metres, scores 0 = blind and 1 = expert."""

    rank: int
    theta_deg: float
    phi_deg: float
    repeats: int
    return_mean: float
    return_low: float | None
    return_high: float | None
    score_mean: float
    score_low: float | None
    score_high: float | None
    difference_to_best: float | None
    difference_low: float | None
    difference_high: float | None
    best_chance: float | None
    verdict: Verdict
    duplicates: list[str]


class SceneVerdict(Table):
    """What the ranking says about a scene as a whole."""

    kind: Literal["best", "not separated", "not above blind"]
    keys: list[str]
    sentence: str
    more_repeats: int | None


class Spread(Table):
    """The spread of one training (m): about a view's own mean, and in differences between views."""

    pooled_sd: float | None
    df: float | None
    residual_sd: float | None
    residual_df: float | None


class DqnView(Table):
    """What the deep Q-networks of one view reached."""

    return_mean: float
    score_mean: float
    score_of_restricted_mean: float


class Dqn(Table):
    """What the deep Q-networks of a scene reached."""

    repeats: int
    viewpoints: dict[str, DqnView]
    score_half_width: float | None
    restricted_expert_return: float
    factorial: Factorial | None


class Judges(Table):
    """Whether what a view gives depends on the judge."""

    test: FTest | None
    effects: list[EffectByJudge]


class Ranking(Table):
    """One scene's ranking, ``reports/rankings/{scene}.json``."""

    scene: str
    confidence: float
    verdict: SceneVerdict
    viewpoints: dict[str, Ranked]
    pairs: list[Pair]
    spread: Spread
    gap: Gap
    factorial: Factorial | None
    dqn: Dqn | None
    judges: Judges | None
    claims: list[Held]
    baselines: list[Compared]
    made_with: dict[str, Any]


class Alignment(Table):
    """The rankings held against people, ``reports/alignment.json``."""

    trials: list[people.Compared]
    agreements: list[people.Agreement]


class Anchors(Table):
    """What a return means in a scene, ``reports/anchors/{scene}.json``; returns in metres."""

    no_op_mean: float
    blind_mean: float
    expert_mean: float
    expert_within_2cm_share_mean: float


class Vae(Table):
    """What a branch's first network saw and lost, ``vae.json``; probe errors in metres."""

    reconstruction_error_mean: float
    kl_nats_mean: float
    active_dimensions_mean: float
    probe_linear_tip_m_mean: float
    probe_linear_target_m_mean: float
    probe_linear_tip_to_target_m_mean: float
    probe_mlp_tip_m_mean: float
    probe_mlp_target_m_mean: float
    probe_mlp_tip_to_target_m_mean: float
    target_seen_share_mean: float
    frames_target_hidden_share_mean: float


class Mdnrnn(Table):
    """How well a branch's second network foresees, ``mdnrnn.json``; nats a frame."""

    heldout_nll_mean: float
    heldout_nll_of_last_frame_mean: float


class Evaluation(Table):
    """What a branch's incumbent reached, ``evaluation.json``."""

    final_distance_m_mean: float
    within_2cm_share_mean: float
    within_5cm_share_mean: float


def read(table: type[TableT], path: Path, made_by: str) -> TableT:
    """Reads one table.

    Args:
        table: its type.
        path: the JSON file.
        made_by: the stage that writes it, named in errors.

    Raises:
        BelvedereError: the file is missing or foreign, or an entry is missing or not valid.
    """
    try:
        return table.model_validate(read_json(path, made_by))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise BelvedereError(
            f"{path}: {place} is not valid ({first['msg']}); `dvc repro {made_by}` makes it anew."
        ) from None
