"""Latent probes: how well tip and target can be read from z. Where it cannot, a view is not ranked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor, nn

from pipeline.learning.training import seeded
from pipeline.worldmodel.params import ProbeParams

SMALLEST_SCALE = 1e-6  # axes that do not move (1-DOF) are not blown up


@dataclass(frozen=True)
class Labelled:
    """Latents with the positions they should tell.

    Attributes:
        latents: (n, 32) posterior means.
        tip_m: (n, 3).
        target_m: (n, 3).
        error_m: (n, 3), the task's: from the target to what shall come there, tip - target in reaching.
    """

    latents: np.ndarray
    tip_m: np.ndarray
    target_m: np.ndarray
    error_m: np.ndarray

    def labels(self) -> Tensor:
        """(n, 9), metres: tip, target, error."""
        columns = [self.tip_m, self.target_m, self.error_m]
        return torch.from_numpy(np.concatenate(columns, axis=1).astype(np.float32))


def label(latents: Tensor, tip_m: np.ndarray, target_m: np.ndarray, error_m: np.ndarray) -> Labelled:
    """Latents (e · t, 32) of e episodes of t frames with tips, targets and errors (e, t, 3)."""
    return Labelled(latents.numpy(), *(each.reshape(-1, 3) for each in (tip_m, target_m, error_m)))


def probe(training: Labelled, heldout: Labelled, params: ProbeParams, seed: int) -> dict[str, float]:
    """Held-out root mean squared distance, in metres, of tip, target and the task's error (tip - target
    in reaching) read from z.

    Beside the probes' errors stand those of a guess that does not look: the mean of the training data.

    Args:
        training: what the probes are fitted on.
        heldout: what they are tested on, from other episodes.
        params: the network probe.
        seed: its first weights and order.
    """
    scale = _Scale(training)
    inputs, unseen = scale.inputs(training), scale.inputs(heldout)
    linear = _linear(inputs, scale.outputs(training))
    errors = _errors("guess", scale.metres(torch.zeros(len(unseen), 9)), heldout)
    errors |= _errors("probe_linear", scale.metres(_with_one(unseen) @ linear), heldout)
    network = _network(inputs, scale.outputs(training), params, seed)
    with torch.inference_mode():
        errors |= _errors("probe_mlp", scale.metres(network(unseen)), heldout)
    return errors


class _Scale:
    """Standardisation by the training data."""

    def __init__(self, training: Labelled) -> None:
        latents, labels = torch.from_numpy(training.latents), training.labels()
        self._in = latents.mean(0), latents.std(0).clamp(min=SMALLEST_SCALE)
        self._out = labels.mean(0), labels.std(0)

    def inputs(self, data: Labelled) -> Tensor:
        return (torch.from_numpy(data.latents) - self._in[0]) / self._in[1]

    def outputs(self, data: Labelled) -> Tensor:
        return (data.labels() - self._out[0]) / self._out[1].clamp(min=SMALLEST_SCALE)

    def metres(self, outputs: Tensor) -> Tensor:
        return outputs * self._out[1] + self._out[0]


def _with_one(inputs: Tensor) -> Tensor:
    return torch.cat([inputs, torch.ones(len(inputs), 1)], dim=1)


def _linear(inputs: Tensor, outputs: Tensor) -> Tensor:
    """Least squares, (33, 9), in closed form; rank-deficient inputs (dead latents) are allowed."""
    system = _with_one(inputs).double()
    return torch.linalg.lstsq(system, outputs.double(), driver="gelsd").solution.float()


def _network(inputs: Tensor, outputs: Tensor, params: ProbeParams, seed: int) -> nn.Module:
    generator = seeded(seed)
    width = params.hidden_units
    network = nn.Sequential(
        nn.Linear(inputs.shape[1], width), nn.Tanh(), nn.Linear(width, width), nn.Tanh(), nn.Linear(width, 9)
    )
    for layer in network:
        if isinstance(layer, nn.Linear):
            nn.init.xavier_uniform_(layer.weight, generator=generator)
            nn.init.zeros_(layer.bias)
    optimizer = torch.optim.Adam(network.parameters(), lr=params.learning_rate, fused=True)
    decay = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, params.steps)
    for _ in range(params.steps):
        chosen = torch.randint(len(inputs), (min(params.batch, len(inputs)),), generator=generator)
        error = (network(inputs[chosen]) - outputs[chosen]).square().mean()
        optimizer.zero_grad()
        error.backward()
        optimizer.step()
        decay.step()
    return network.eval()


def _errors(kind: str, read_m: Tensor, heldout: Labelled) -> dict[str, float]:
    squared = (read_m - heldout.labels()).square().unflatten(1, (3, 3)).sum(2).mean(0)
    names = ("tip", "target", "tip_to_target")
    return {f"{kind}_{n}_m": float(s) for n, s in zip(names, squared.sqrt(), strict=True)}
