"""The mdnrnn stage on a motion it can learn: better than standing still, the same bytes twice."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline import mdnrnn
from pipeline.contract.errors import BelvedereError
from pipeline.storage import zarrs
from pipeline.worldmodel.mdnrnn import load_mdnrnn
from tests.stages.worldmodel_stages import Workplace
from tests.stores import write_store

REPEATS, EPISODES, FRAMES = 2, 20, 20
FLAGS = ("--latents", "latents", "--out", "mdnrnn", "--metrics", "mdnrnn.json")


def _write_latents(path: Path, broken: bool = False) -> None:
    """Two latents that the actions push about; the others carry nothing, as in a VAE (N(0, 1))."""
    rng = np.random.default_rng(1)
    actions = rng.uniform(-1, 1, (REPEATS, EPISODES, FRAMES, 2)).astype(np.float32)
    mean = np.zeros((REPEATS, EPISODES, FRAMES, 32), np.float32)
    mean[:, :, 1:, :2] = actions[:, :, :-1].cumsum(2)
    log_variance = np.zeros_like(mean)
    log_variance[..., :2] = -6.0
    if broken:
        mean[0, 0, 0, 0] = np.nan
    reward = np.zeros((REPEATS, EPISODES, FRAMES))
    arrays = {"mean": mean, "log_variance": log_variance, "action": actions, "reward": reward}
    write_store(path, zarrs.LATENTS, arrays, {"scene": "panda_2dof", "theta_deg": 0.0, "phi_deg": 0.0})


def test_it_predicts_what_actions_do_and_the_same_on_two_cores(tmp_path: Path) -> None:
    written = []
    for name, cores in (("one", 1), ("two", 2)):
        place = Workplace(tmp_path / name, cores)
        place.root.mkdir()
        place.write_params(mdnrnn_epochs=15)
        _write_latents(place.root / "latents")
        place.run("mdnrnn", *FLAGS)
        written.append(place.bytes_of("mdnrnn", "mdnrnn.json"))
    assert written[0] == written[1]
    metrics = json.loads((tmp_path / "one" / "mdnrnn.json").read_text())
    assert [r["repeat"] for r in metrics["repeats"]] == [0, 1]
    assert (
        metrics["heldout_nll_nats_per_latent_mean"]
        < metrics["heldout_nll_of_last_frame_nats_per_latent_mean"] - 0.2
    )
    assert load_mdnrnn(tmp_path / "one" / "mdnrnn" / "repeat_1.pt").actions == 2


def test_numbers_that_are_none_are_refused(tmp_path: Path) -> None:
    place = Workplace(tmp_path)
    place.write_params()
    _write_latents(tmp_path / "latents", broken=True)
    said = place.run("mdnrnn", *FLAGS, status=1)
    assert "error: mdnrnn: in epoch 1 the training loss is nan" in said
    assert "mdnrnn.schedule.learning_rate" in said
    assert not (tmp_path / "mdnrnn").exists()


@pytest.mark.parametrize("value", [-1, 0, "fast"])
def test_a_bad_size_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, value: object) -> None:
    place = Workplace(tmp_path)
    place.write_params(mdnrnn_epochs=value)  # type: ignore[arg-type]
    _write_latents(tmp_path / "latents")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BelvedereError, match=rf"budgets\.short\.mdnrnn\.epochs = {value!r} is not valid"):
        mdnrnn.main(latents=Path("latents"), out=Path("mdnrnn"), metrics=Path("mdnrnn.json"))
