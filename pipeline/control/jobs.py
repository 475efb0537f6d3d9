"""What closed loops are asked: some controllers, in some episodes, seeing through one world model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.control.policy import FEATURES, Controllers
from pipeline.learning.device import Compute
from pipeline.sim.draws import Episodes
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.mdnrnn import MdnRnn, load_mdnrnn
from pipeline.worldmodel.vae import load_vae


@dataclass(frozen=True, eq=False)
class Networks:
    """A world model as the loop uses it: pictures to z, and what h comes from (on the CPU)."""

    encoder: Encoder
    rnn: MdnRnn

    @staticmethod
    def load(vae: Path, mdnrnn: Path, compute: Compute) -> Networks:
        """What stages ``vae`` and ``mdnrnn`` wrote.

        Raises:
            BelvedereError: a file is missing, truncated or foreign.
        """
        return Networks(Encoder(load_vae(vae), compute), load_mdnrnn(mdnrnn))


@dataclass(frozen=True, eq=False)
class Job:
    """Runs ``controllers[i]`` in ``episodes[i]``, for all i.

    Attributes:
        member: which of the loop's networks the controllers see through.
        controllers: n controllers.
        episodes: n episodes.
    """

    member: int
    controllers: Controllers
    episodes: Episodes

    @staticmethod
    def of(member: int, candidates: np.ndarray, episodes: Episodes) -> Job:
        """Each of the candidates, flat parameters (p, actions × 289), in each of the episodes."""
        actions = candidates.shape[1] // (FEATURES + 1)
        controllers = Controllers.of(candidates, actions, each=len(episodes))
        return Job(member, controllers, episodes.tiled(len(candidates)))

    def __post_init__(self) -> None:
        if len(self.controllers) != len(self.episodes):
            raise ValueError(f"{len(self.controllers)} controllers for {len(self.episodes)} episodes")
