"""The MDN-RNN: published size, torch's mixtures, one step as the whole sequence."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
from scipy import stats
from torch.distributions import Categorical, MixtureSameFamily, Normal

from pipeline.contract.errors import BelvedereError
from pipeline.learning import checkpoints
from pipeline.learning.device import Compute
from pipeline.learning.training import seeded
from pipeline.worldmodel.mdnrnn import MdnRnn, load_mdnrnn, save_mdnrnn
from pipeline.worldmodel.mdnrnn_training import Sequences, fit, initialised, nll_of_last_frame
from pipeline.worldmodel.params import MdnRnnParams, MdnRnnSizes

PARAMS = MdnRnnParams.model_validate(
    {
        "schedule": {"learning_rate": 1e-3, "halve_after_epochs": 5, "stop_after_epochs": 30},
        "log_sigma_bound": 6.0,
        "gradient_norm": 1.0,
    }
)


def _sequences(scale: float = 1.0) -> tuple[torch.Tensor, torch.Tensor]:
    draws = seeded(2)
    return scale * torch.randn(4, 9, 32, generator=draws), torch.rand(4, 9, 2, generator=draws) * 2 - 1


def test_the_published_number_of_parameters() -> None:
    assert sum(weight.numel() for weight in MdnRnn(3, 6.0).parameters()) == 423_392


def test_steps_are_the_sequence() -> None:
    network = initialised(2, PARAMS, seeded(1))
    latents, actions = _sequences()
    with torch.inference_mode():
        expected, _ = network.lstm(torch.cat([latents, actions], dim=-1))
        state = network.initial_state(4)
        assert not state.h.any()
        for t in range(9):
            state = network.step(latents[:, t], actions[:, t], state)
            torch.testing.assert_close(state.h, expected[:, t], rtol=1e-5, atol=1e-6)


def test_nll_is_that_of_torchs_mixtures() -> None:
    latents, actions = _sequences()
    with torch.inference_mode():
        mixture = initialised(2, PARAMS, seeded(1))(latents, actions)
        gaussians = Normal(mixture.mean, mixture.log_sigma.exp())
        theirs = MixtureSameFamily(Categorical(logits=mixture.log_weight), gaussians)
        torch.testing.assert_close(mixture.nll(latents), -theirs.log_prob(latents))


def test_the_metrics_are_per_latent(tmp_path: Path) -> None:
    """Of posteriors N(0, 1) that no action moves, no frame tells more than the entropy of one latent."""
    still = torch.zeros(40, 6, 32)
    episodes = Sequences(still, still, torch.zeros(40, 6, 2))
    place = Compute(torch.device("cpu"), torch.float32)
    sizes = MdnRnnSizes(epochs=8, batch=4)
    _, numbers = fit(episodes, episodes, PARAMS, sizes, place, 1, tmp_path, "a test")
    entropy = stats.norm.entropy()
    assert numbers["training_nll_nats_per_latent"] == pytest.approx(entropy, abs=0.1)
    assert numbers["heldout_nll_nats_per_latent"] == pytest.approx(entropy, abs=0.1)
    doubled = stats.norm(scale=2**0.5).entropy()  # a difference of two frames has twice the variance
    assert numbers["heldout_nll_of_last_frame_nats_per_latent"] == pytest.approx(doubled, abs=0.05)


def test_log_sigma_stays_within_its_bound() -> None:
    network = initialised(2, PARAMS, seeded(1))
    with torch.inference_mode():
        network.mixture.weight.mul_(1e4)
        log_sigma = network(*_sequences(scale=100.0)).log_sigma
    assert float(log_sigma.abs().max()) <= PARAMS.log_sigma_bound
    assert float(log_sigma.abs().max()) > 0.9 * PARAMS.log_sigma_bound


def test_the_last_frames_nll_is_scipys() -> None:
    draws = seeded(5)
    training, heldout = torch.randn(2, 6, 20, 3, generator=draws).cumsum(2) * torch.tensor([1.0, 0.1, 3.0])
    moves = [part.diff(dim=1).reshape(-1, 3).double().numpy() for part in (training, heldout)]
    sigma = (moves[0] ** 2).mean(0) ** 0.5
    expected = -stats.norm.logpdf(moves[1], scale=sigma).mean()
    assert nll_of_last_frame(training, heldout) == pytest.approx(expected, rel=1e-5)


def test_weights_come_back(tmp_path: Path) -> None:
    network = initialised(2, PARAMS, seeded(1))
    save_mdnrnn(tmp_path / "rnn.pt", network)
    again = load_mdnrnn(tmp_path / "rnn.pt")
    assert again.log_sigma_bound == network.log_sigma_bound
    for mine, expected in zip(again.parameters(), network.parameters(), strict=True):
        assert torch.equal(mine, expected)


@pytest.mark.parametrize(
    "content", [{"weight": torch.ones(3)}, {"actions": 2, "log_sigma_bound": 6.0, "weights": {}}]
)
def test_foreign_weights_are_refused(tmp_path: Path, content: dict[str, object]) -> None:
    checkpoints.save(tmp_path / "rnn.pt", content)
    with pytest.raises(BelvedereError, match="holds no weights of an MDN-RNN"):
        load_mdnrnn(tmp_path / "rnn.pt")
