"""The controller: one linear layer, squashed (paper section II-C; Ha and Schmidhuber 2018)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from pipeline.contract.errors import BelvedereError
from pipeline.storage.archives import read_whole
from pipeline.storage.artefacts import writing
from pipeline.worldmodel.mdnrnn import UNITS
from pipeline.worldmodel.vae import LATENTS

FEATURES = LATENTS + UNITS  # z and h


def parameters(actions: int) -> int:
    """How many numbers a controller of so many action dimensions has: 289 each."""
    return actions * (FEATURES + 1)


def hidden_weights(actions: int) -> np.ndarray:
    """Which of a controller's flat parameters are weights of h: shape (actions × 289,), bool."""
    row = np.arange(FEATURES + 1)
    return np.tile((row >= LATENTS) & (row < FEATURES), actions)


@dataclass(frozen=True)
class Controllers:
    """A batch of linear controllers, one per row: action = tanh(W [z, h] + b).

    Attributes:
        weight: shape (n, actions, 288), float32; the last axis is z, then h.
        bias: shape (n, actions), float32.
    """

    weight: Tensor
    bias: Tensor

    @staticmethod
    def of(candidates: np.ndarray, actions: int, each: int = 1) -> Controllers:
        """Controllers from flat parameters (p, actions × 289), each repeated ``each`` times in a row."""
        rows = torch.from_numpy(candidates.astype(np.float32)).view(len(candidates), actions, FEATURES + 1)
        rows = rows.repeat_interleave(each, dim=0)
        return Controllers(rows[..., :-1].contiguous(), rows[..., -1].contiguous())

    def __getitem__(self, index: Tensor) -> Controllers:
        return Controllers(self.weight[index], self.bias[index])

    def __len__(self) -> int:
        return len(self.weight)

    def to(self, device: torch.device | str) -> Controllers:
        """The same controllers on a device."""
        return Controllers(self.weight.to(device), self.bias.to(device))

    def __call__(self, latents: Tensor, hidden: Tensor) -> Tensor:
        """Actions (n, actions) in (-1, 1) at z (n, 32) and h (n, 256)."""
        features = torch.cat([latents, hidden], dim=1)[:, :, None]
        return torch.tanh(torch.baddbmm(self.bias[:, :, None], self.weight, features)[:, :, 0])


def save_controller(path: Path, flat: np.ndarray) -> None:
    """Writes one controller's flat parameters as ``weight`` (actions, 288) and ``bias`` (actions,)."""
    rows = flat.reshape(-1, FEATURES + 1)
    with writing(path) as aside, aside.open("wb") as file:
        np.savez(file, weight=rows[:, :-1], bias=rows[:, -1])


def load_controller(path: Path, actions: int) -> np.ndarray:
    """The flat parameters (actions × 289,) of what ``pipeline.controller`` wrote to ``path``.

    Raises:
        BelvedereError: the file is missing, foreign, or of another number of actions.
    """
    if not Path(path).is_file():
        raise BelvedereError(f"{path} is missing; `dvc repro controller` makes it.")
    try:
        with np.load(read_whole(path), allow_pickle=False) as arrays:
            rows = np.concatenate([arrays["weight"], arrays["bias"][:, None]], axis=1)
    except Exception as error:  # numpy raises many types on a truncated or foreign file
        raise BelvedereError(
            f"{path} cannot be read ({type(error).__name__}); delete it and run `dvc repro controller`."
        ) from None
    if rows.shape != (actions, FEATURES + 1):
        raise BelvedereError(
            f"{path} holds weights of shape {rows.shape}, not {(actions, FEATURES + 1)}; delete it and run "
            "`dvc repro controller`."
        )
    return np.asarray(rows).reshape(-1)
