"""Trains a deep Q-network from one viewpoint."""

from __future__ import annotations

from dataclasses import dataclass

import polars as pl
from stable_baselines3 import DQN
from stable_baselines3.common.callbacks import BaseCallback

from pipeline.contract import memory, params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import CORES_VARIABLE
from pipeline.contract.progress import Progress
from pipeline.learning.device import Compute
from pipeline.qlearning.params import DqnParams, DqnSizes
from pipeline.qlearning.task_env import TaskEnv
from pipeline.rendering.visibility import PICTURE_SIZE

_TRANSITION_BYTES = 2 * PICTURE_SIZE**2 * 3 + 8 + 4 + 4 + 4  # two pictures, action, reward, done, timeout


def memory_bytes(sizes: DqnSizes) -> int:
    """What the replay memory takes."""
    return sizes.memory * _TRANSITION_BYTES


def require_memory(method: DqnParams, sizes: DqnSizes, at_a_time: int) -> None:
    """Refuses a replay memory that the machine's memory does not hold, in so many trainings at a time.

    Raises:
        BelvedereError: it is too large.
    """

    def remedy(there: int) -> str:
        calls = there // (at_a_time * _TRANSITION_BYTES * method.worlds)
        fewer = f", and more where {CORES_VARIABLE}=1 trains one after the other" if at_a_time > 1 else ""
        return f"at most {calls * method.worlds} fit{fewer}"

    place = f"{params.PARAMS_FILE}: budgets.{params.budget()}.dqn.memory"
    what = f"{place} = {sizes.memory} transitions, in {at_a_time} training(s) at a time,"
    memory.require(at_a_time * memory_bytes(sizes), what, remedy)


@dataclass(frozen=True)
class Trained:
    """A trained network.

    Attributes:
        model: stable-baselines3's.
        curve: columns ``generation`` (count of ended batches of episodes), ``frames`` seen so far, ``mean``
            and ``best`` return, paper eq. (2), of the batch's episodes, random actions included.
    """

    model: DQN
    curve: pl.DataFrame


def network(env: TaskEnv, method: DqnParams, sizes: DqnSizes, compute: Compute, seed: int) -> DQN:
    """An untrained network with a convolutional policy (Mnih et al. 2015) on one picture at a time."""
    return DQN(
        "CnnPolicy",
        env,
        learning_rate=method.learning_rate,
        buffer_size=sizes.memory,
        learning_starts=env.num_envs * env.frames,
        batch_size=method.batch,
        gamma=method.discount,
        train_freq=(1, "step"),
        gradient_steps=env.num_envs // sizes.frames_per_step,
        target_update_interval=sizes.target_every,
        exploration_fraction=method.exploration.over,
        exploration_initial_eps=method.exploration.first,
        exploration_final_eps=method.exploration.last,
        seed=seed % 2**31,
        device=compute.device,
    )


def fit(env: TaskEnv, method: DqnParams, sizes: DqnSizes, compute: Compute, seed: int, what: str) -> Trained:
    """Trains a network.

    Args:
        env: the worlds.
        method: learning rate, discount, exploration.
        sizes: frames, memory, gradient steps.
        compute: where.
        seed: of stable-baselines3, which seeds Python's, NumPy's and torch's global generators with it.
        what: the progress bar's words.

    Raises:
        BelvedereError: the network diverged.
    """
    model = network(env, method, sizes, compute, seed)
    with Progress(sizes.frames, what) as progress:
        model.learn(sizes.frames, callback=_Telling(env, progress))
    if not all(bool(weight.isfinite().all()) for weight in model.policy.parameters()):
        raise BelvedereError(
            f"{what}: the network's weights are no longer finite numbers; lower dqn.learning_rate "
            f"(now {method.learning_rate:g}) in params.yaml."
        )
    frames = env.num_envs * env.frames
    rows = [(i, (i + 1) * frames, float(r.mean()), float(r.max())) for i, r in enumerate(env.returns)]
    curve = pl.DataFrame(rows, schema=["generation", "frames", "mean", "best"], orient="row")
    return Trained(model, curve)


class _Telling(BaseCallback):
    """Tells the progress bar."""

    def __init__(self, env: TaskEnv, progress: Progress) -> None:
        super().__init__()
        self._env, self._progress = env, progress

    def _on_step(self) -> bool:
        facts = {"returned": f"{self._env.returns[-1].mean():.2f}"} if self._env.returns else {}
        self._progress.advance(self._env.num_envs, **facts)
        return True
