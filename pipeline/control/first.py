"""The controller from which CMA-ES starts: which way the reward rises, read linearly from [z, h].

In the random episodes a frame changes the reward by about a · g, where a is the action and g points
to the target. A linear controller can at best say W [z, h] + b ≈ g, so W and b are the least-squares
solution, over the episodes on which the networks were trained, of

    r(t) - r(t - 1)  ≈  a(t) · (W [z(t), h(t)] + b)  +  c · [z(t), h(t)] + d,

in which the second part takes up what happens whatever the action. It uses nothing that the world
model's own training episodes do not hold, and spares CMA-ES the search for a needle in hundreds of
dimensions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from pipeline.control.policy import FEATURES
from pipeline.worldmodel.mdnrnn import MdnRnn

_WIDTH = FEATURES + 1  # z, h and the constant 1


@dataclass(frozen=True)
class Experience:
    """Random episodes as the world model saw them.

    Attributes:
        latents: posterior means of z, (e, t, 32), float32.
        action: (e, t, a), float32, each after the picture of its frame.
        reward: paper eq. (1), m, after each action, (e, t).
    """

    latents: Tensor
    action: Tensor
    reward: Tensor

    @staticmethod
    def of(mean: np.ndarray, action: np.ndarray, reward: np.ndarray) -> Experience:
        return Experience(torch.from_numpy(mean), torch.from_numpy(action), torch.from_numpy(reward))


def from_rewards(rnn: MdnRnn, experience: Experience, ridge: float) -> np.ndarray:
    """The flat parameters (a × 289,) of the controller that follows the reward's slope.

    They are scaled so that what enters the tanh has mean square 1 over the episodes; where all rewards of an
    episode are the same there is no slope, and they are zero.

    Args:
        rnn: what h comes from.
        experience: at least two frames an episode.
        ridge: penalty on each parameter, as a share of its column's sum of squares.
    """
    actions = experience.action.shape[-1]
    with torch.inference_mode():
        gram, moment = _normal_equations(rnn, experience)
        sizes = gram.diagonal().clamp(min=torch.finfo(gram.dtype).tiny)
        solution = torch.linalg.solve(gram + torch.diag(ridge * sizes), moment)
        rows = solution[: actions * _WIDTH].reshape(actions, _WIDTH)
        squares = gram[-_WIDTH:, -_WIDTH:]  # the features' own sums of products; the last is their count
        mean_square = ((rows @ squares) * rows).sum() / (actions * squares[-1, -1])
        if mean_square == 0.0:  # no reward ever changed, as where no episode touched what is to be pushed
            return np.zeros(actions * _WIDTH)
        return np.asarray((rows / mean_square.sqrt()).reshape(-1).numpy())


def _normal_equations(rnn: MdnRnn, experience: Experience) -> tuple[Tensor, Tensor]:
    """Sums of products of the columns, ((a + 1) · 289) squared, and of columns and reward changes."""
    latents, action, reward = experience.latents, experience.action, experience.reward.double()
    columns = (action.shape[-1] + 1) * _WIDTH
    gram = torch.zeros(columns, columns, dtype=torch.float64)
    moment = torch.zeros(columns, dtype=torch.float64)
    state = rnn.initial_state(len(latents))
    for t in range(latents.shape[1]):
        if t > 0:
            one = torch.ones(len(latents), 1)
            features = torch.cat([latents[:, t], state.h, one], dim=1).double()
            weights = torch.cat([action[:, t].double(), one.double()], dim=1)
            rows = (weights[:, :, None] * features[:, None]).flatten(1)
            gram += rows.T @ rows
            moment += rows.T @ (reward[:, t] - reward[:, t - 1])
        state = rnn.step(latents[:, t], action[:, t], state)
    return gram, moment
