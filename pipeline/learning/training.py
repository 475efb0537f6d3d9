"""The one training loop: Adam, halved on a plateau, stopped on a longer one, resumable to the bit."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from pipeline.contract.errors import BelvedereError
from pipeline.contract.progress import Progress
from pipeline.learning import checkpoints
from pipeline.learning.params import Schedule

CHECKPOINT_EVERY_S = 15.0


@dataclass(frozen=True)
class Problem:
    """What is to be learnt.

    Attributes:
        stage: the stage's name, for errors and progress.
        model: the network; holds the best weights after :func:`train`.
        items: number of training items.
        batch: items per step.
        epochs: at most so many passes.
        loss: mean loss of the items at the given indices; draws come from the generator alone.
        heldout_loss: the loss by which weights are compared; must draw nothing.
        gradient_norm: longer gradients are scaled down to this 2-norm; None leaves them.
    """

    stage: str
    model: nn.Module
    items: int
    batch: int
    epochs: int
    loss: Callable[[Tensor, torch.Generator], Tensor]
    heldout_loss: Callable[[], float]
    gradient_norm: float | None = None


@dataclass
class Plateau:
    """How far training has come.

    Attributes:
        epoch: epochs done.
        best_epoch: the epoch whose weights count, from 1.
        best_loss: its held-out loss.
        training_loss: its training loss.
        since_halving: epochs without improvement since the last one, or since the last halving.
    """

    epoch: int = 0
    best_epoch: int = 0
    best_loss: float = math.inf
    training_loss: float = math.inf
    since_halving: int = 0

    def record(self, training_loss: float, heldout_loss: float) -> bool:
        """Counts an epoch; True if it is the best so far."""
        self.epoch += 1
        if heldout_loss < self.best_loss:
            self.best_epoch, self.best_loss, self.training_loss = self.epoch, heldout_loss, training_loss
            self.since_halving = 0
            return True
        self.since_halving += 1
        return False

    def finished(self, schedule: Schedule, epochs: int) -> bool:
        return self.epoch >= epochs or self.epoch - self.best_epoch >= schedule.stop_after_epochs


def seeded(seed: int) -> torch.Generator:
    """A CPU generator: the same draws whatever the device."""
    return torch.Generator().manual_seed(seed)


def train(
    problem: Problem, schedule: Schedule, generator: torch.Generator, running: Path, what: str
) -> Plateau:
    """Trains ``problem.model`` and leaves the weights of the best held-out epoch in it.

    Args:
        problem: what is to be learnt.
        schedule: learning rate and plateau rule (paper, section IV-B).
        generator: the only source of randomness.
        running: folder for the running checkpoint; a checkpoint found there is continued, and the
            result is the same to the last bit as without interruption. A damaged one is skipped.
        what: the progress bar's words.

    Raises:
        BelvedereError: the loss is no longer a finite number.
    """
    model, checkpoint = problem.model, Path(running) / "checkpoint.pt"
    optimizer = torch.optim.Adam(model.parameters(), lr=schedule.learning_rate, fused=True)
    plateau, best = Plateau(), copy.deepcopy(model.state_dict())
    if checkpoint.is_file():
        plateau, best = _continued(checkpoint, problem, optimizer, generator)
    saved_s = time.monotonic()
    with Progress(problem.epochs, what, initial=plateau.epoch) as progress:
        while not plateau.finished(schedule, problem.epochs):
            losses = _epoch(problem, optimizer, generator)
            _refuse_not_finite(problem, schedule, plateau.epoch + 1, losses)
            if count_epoch(plateau, optimizer, schedule, losses):
                best = copy.deepcopy(model.state_dict())
            progress.advance(loss=f"{losses[0]:.4g}", heldout=f"{losses[1]:.4g}")
            if time.monotonic() - saved_s > CHECKPOINT_EVERY_S:
                checkpoints.save(checkpoint, _state(problem, optimizer, generator, plateau, best))
                saved_s = time.monotonic()
    model.load_state_dict(best)
    return plateau


def _epoch(
    problem: Problem, optimizer: torch.optim.Optimizer, generator: torch.Generator
) -> tuple[float, float]:
    """One pass; returns the mean training loss on the way and the held-out loss after it."""
    problem.model.train()
    order = torch.randperm(problem.items, generator=generator)
    total = 0.0
    for indices in order.tensor_split(math.ceil(problem.items / problem.batch)):
        loss = problem.loss(indices, generator)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        if problem.gradient_norm is not None:
            nn.utils.clip_grad_norm_(problem.model.parameters(), problem.gradient_norm)
        optimizer.step()
        total += float(loss.detach()) * len(indices)
    problem.model.eval()
    with torch.inference_mode():
        return total / problem.items, problem.heldout_loss()


def count_epoch(
    plateau: Plateau, optimizer: torch.optim.Optimizer, schedule: Schedule, losses: tuple[float, float]
) -> bool:
    """Counts an epoch with its training and held-out loss; True if it is the best so far.

    Halves the learning rate when the plateau is long enough, and then counts again.
    """
    if plateau.record(*losses):
        return True
    if plateau.since_halving >= schedule.halve_after_epochs:
        plateau.since_halving = 0
        for group in optimizer.param_groups:
            group["lr"] *= 0.5
    return False


def _refuse_not_finite(problem: Problem, schedule: Schedule, epoch: int, losses: tuple[float, float]) -> None:
    if not all(math.isfinite(loss) for loss in losses):
        raise BelvedereError(
            f"{problem.stage}: in epoch {epoch} the training loss is {losses[0]} and the held-out loss "
            f"{losses[1]}; lower {problem.stage}.schedule.learning_rate "
            f"(now {schedule.learning_rate:g}) in params.yaml, or look at the stage's input."
        )


def _state(
    problem: Problem,
    optimizer: torch.optim.Optimizer,
    generator: torch.Generator,
    plateau: Plateau,
    best: dict[str, Any],
) -> dict[str, Any]:
    return {
        "model": problem.model.state_dict(),
        "best": best,
        "optimizer": optimizer.state_dict(),
        "generator": generator.get_state(),
        "plateau": asdict(plateau),
    }


def _continued(
    checkpoint: Path, problem: Problem, optimizer: torch.optim.Optimizer, generator: torch.Generator
) -> tuple[Plateau, dict[str, Any]]:
    begun = copy.deepcopy(_state(problem, optimizer, generator, Plateau(), problem.model.state_dict()))
    try:
        return _restore(checkpoints.load(checkpoint, problem.stage), problem, optimizer, generator)
    except Exception as error:  # torch raises many types on a foreign state
        print(f"{checkpoint} is damaged ({type(error).__name__}); the training starts again.")
        return _restore(begun, problem, optimizer, generator)


def _restore(
    state: dict[str, Any], problem: Problem, optimizer: torch.optim.Optimizer, generator: torch.Generator
) -> tuple[Plateau, dict[str, Any]]:
    problem.model.load_state_dict(state["model"])
    optimizer.load_state_dict(state["optimizer"])
    generator.set_state(state["generator"])
    return Plateau(**state["plateau"]), state["best"]
