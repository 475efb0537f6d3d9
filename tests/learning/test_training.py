"""The training loop: resumed to the bit, halved and stopped as torch's own rule, refusing NaN."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import torch
from torch import Tensor, nn

from pipeline.contract.errors import BelvedereError
from pipeline.learning import checkpoints, training
from pipeline.learning.params import Schedule
from pipeline.learning.training import Plateau, Problem, seeded, train
from tests.damage import flipped

SCHEDULE = Schedule(learning_rate=0.01, halve_after_epochs=2, stop_after_epochs=50)


class _Killed(Exception):
    pass


def _problem(epochs: int = 12, killed_at: int | None = None) -> Problem:
    """A noisy regression whose loss draws from the generator, as the VAE's does."""
    draws = seeded(3)
    inputs = torch.randn(40, 5, generator=draws)
    expected = (inputs @ torch.randn(5, 1, generator=draws)).tanh()
    model = nn.Sequential(nn.Linear(5, 8), nn.Tanh(), nn.Linear(8, 1))
    for weight in model.parameters():
        nn.init.uniform_(weight, -0.3, 0.3, generator=draws)
    steps = 0

    def loss(indices: Tensor, generator: torch.Generator) -> Tensor:
        nonlocal steps
        steps += 1
        if steps == killed_at:
            raise _Killed
        noise = 0.3 * torch.randn(len(indices), 5, generator=generator)
        return (model(inputs[indices] + noise) - expected[indices]).square().mean()

    def heldout_loss() -> float:
        return float((model(inputs[30:]) - expected[30:]).square().mean())

    return Problem("vae", model, 30, 8, epochs, loss, heldout_loss, gradient_norm=0.5)


def _weights(problem: Problem) -> Tensor:
    return torch.cat([weight.detach().flatten() for weight in problem.model.parameters()])


def test_a_killed_training_continues_to_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = _problem()
    undisturbed = train(whole, SCHEDULE, seeded(7), tmp_path, "whole")
    monkeypatch.setattr(training, "CHECKPOINT_EVERY_S", -1.0)
    running = tmp_path / "running"
    for step in (9, 23):  # in the third epoch, and in the sixth after that
        with pytest.raises(_Killed):
            train(_problem(killed_at=step), SCHEDULE, seeded(7), running, "killed")
    continued = _problem()
    assert train(continued, SCHEDULE, seeded(7), running, "continued") == undisturbed
    assert torch.equal(_weights(continued), _weights(whole))


@pytest.mark.parametrize("damage", ["empty", "half", "junk", "flipped", "another", "nothing in it"])
def test_a_damaged_checkpoint_is_passed_over_with_a_word(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], damage: str
) -> None:
    whole = _problem()
    undisturbed = train(whole, SCHEDULE, seeded(7), tmp_path, "whole")
    monkeypatch.setattr(training, "CHECKPOINT_EVERY_S", -1.0)
    with pytest.raises(_Killed):
        train(_problem(killed_at=9), SCHEDULE, seeded(7), tmp_path, "killed")
    checkpoint = tmp_path / "checkpoint.pt"
    good = checkpoint.read_bytes()
    half = len(good) // 2
    if damage in ("another", "nothing in it"):
        another = {"model": _problem().model.state_dict(), "best": {}, "optimizer": {}}
        checkpoints.save(checkpoint, another if damage == "another" else {})
    else:
        ways = {"empty": b"", "half": good[:half], "junk": b"junk", "flipped": flipped(good, 8 * half)}
        checkpoint.write_bytes(ways[damage])
    again = _problem()
    assert train(again, SCHEDULE, seeded(7), tmp_path, "the training") == undisturbed
    assert torch.equal(_weights(again), _weights(whole))
    assert "the training starts again" in capsys.readouterr().out


def test_the_best_heldout_weights_are_kept(tmp_path: Path) -> None:
    problem = _problem(epochs=20)
    plateau = train(problem, SCHEDULE, seeded(7), tmp_path, "best")
    with torch.inference_mode():
        assert problem.heldout_loss() == plateau.best_loss
    assert 1 <= plateau.best_epoch <= plateau.epoch == 20


def test_nothing_is_drawn_from_the_global_generator(tmp_path: Path) -> None:
    problem = _problem(epochs=2)
    before = torch.get_rng_state()
    train(problem, SCHEDULE, seeded(7), tmp_path, "draws")
    assert torch.equal(torch.get_rng_state(), before)


@pytest.mark.parametrize("seed", range(5))
def test_halving_agrees_with_torchs_scheduler(tmp_path: Path, seed: int) -> None:
    """torch halves when bad epochs exceed its patience, so a patience of 4 is ours of 5."""
    losses = torch.rand(60, generator=seeded(seed)).cummin(0).values.tolist()
    schedule = Schedule(learning_rate=1e-3, halve_after_epochs=5, stop_after_epochs=30)
    weight = nn.Parameter(torch.ones(1))
    ours, theirs = (torch.optim.Adam([weight], lr=1e-3) for _ in range(2))
    judge = torch.optim.lr_scheduler.ReduceLROnPlateau(theirs, factor=0.5, patience=4, threshold=0.0)
    plateau = Plateau()
    for loss in losses:
        training.count_epoch(plateau, ours, schedule, (0.0, loss))
        judge.step(loss)
        assert ours.param_groups[0]["lr"] == theirs.param_groups[0]["lr"]


def test_it_stops_after_as_many_epochs_without_improvement(tmp_path: Path) -> None:
    problem = _problem(epochs=1000)
    flat = Problem("vae", problem.model, 30, 8, 1000, problem.loss, lambda: 1.0)
    schedule = Schedule(learning_rate=1e-3, halve_after_epochs=2, stop_after_epochs=6)
    assert train(flat, schedule, seeded(1), tmp_path, "flat").epoch == 1 + 6


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_loss_that_is_no_number_is_refused_in_a_sentence(tmp_path: Path, bad: float) -> None:
    problem = _problem(epochs=3)
    broken = Problem("mdnrnn", problem.model, 30, 8, 3, problem.loss, lambda: bad)
    with pytest.raises(
        BelvedereError, match=r"mdnrnn: in epoch 1 .*mdnrnn\.schedule\.learning_rate \(now 0\.01\)"
    ):
        train(broken, SCHEDULE, seeded(1), tmp_path, "bad")
