"""The vae stage on real frames: killed and continued, extended by a repeat, refusing bad input."""

from __future__ import annotations

import json
import shutil
import time
from pathlib import Path

import pytest
from PIL import Image

from tests.stages.worldmodel_stages import Workplace, write_frames

EPOCHS = 15
EAGER = "import pipeline.learning.training as training; training.CHECKPOINT_EVERY_S = -1.0"
NO_TRAINING = "import pipeline.vae as vae; vae.fit = None"


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("frames") / "frames"
    write_frames(path, repeats=2)
    return path


@pytest.fixture(scope="module")
def undisturbed(frames: Path, tmp_path_factory: pytest.TempPathFactory) -> Workplace:
    place = Workplace(tmp_path_factory.mktemp("undisturbed"))
    place.write_params(vae_epochs=EPOCHS)
    place.run("vae", *place.vae(frames))
    return place


def test_it_writes_weights_metrics_and_a_picture(undisturbed: Workplace) -> None:
    metrics = json.loads((undisturbed.root / "vae.json").read_text())
    assert (metrics["scene"], metrics["theta_deg"], metrics["phi_deg"]) == ("panda_2dof", 45.0, 15.0)
    first, second = metrics["repeats"]
    for name, value in first.items():
        if name != "repeat":
            assert metrics[f"{name}_mean"] == pytest.approx((value + second[name]) / 2)
    assert 0 < first["probe_mlp_tip_m"] < 0.3
    assert 0.5 < first["target_seen_share"] <= 1 and first["frames_target_hidden_share"] < 0.5
    assert first["heldout_loss"] < 600  # a grey picture's is above 1,000
    assert sorted(p.name for p in (undisturbed.root / "vae").iterdir()) == ["repeat_0.pt", "repeat_1.pt"]
    assert Image.open(undisturbed.root / "reconstructions.png").size == (8 * 128, 2 * 128)


def test_killed_and_continued_on_two_cores_it_ends_with_the_same_bytes(
    frames: Path, undisturbed: Workplace, tmp_path: Path
) -> None:
    place = Workplace(tmp_path, cores=2)
    place.write_params(vae_epochs=EPOCHS)
    process = place.start("vae", *place.vae(frames), before=EAGER)
    deadline_s = time.monotonic() + 120
    while not list(tmp_path.glob(".scratch/vae/*/running/checkpoint.pt")):
        assert process.poll() is None and time.monotonic() < deadline_s, process.communicate()
        time.sleep(0.01)
    process.kill()
    process.communicate()
    assert not (tmp_path / "vae").exists() and not (tmp_path / "vae.json").exists()
    assert not list(tmp_path.glob(".scratch/vae/*/results"))
    place.run("vae", *place.vae(frames))
    made = ("vae", "vae.json", "reconstructions.png")
    assert place.bytes_of(*made) == undisturbed.bytes_of(*made)
    assert not list(tmp_path.glob(".scratch/vae/*/.results.*"))


def test_more_repeats_train_only_the_added_ones(frames: Path, undisturbed: Workplace, tmp_path: Path) -> None:
    more = tmp_path / "frames"
    write_frames(more, repeats=3)
    place = Workplace(tmp_path)
    place.write_params(vae_epochs=EPOCHS)
    shutil.copytree(undisturbed.root / ".scratch", tmp_path / ".scratch")
    finished = set(tmp_path.glob(".scratch/vae/*"))
    place.run("vae", *place.vae(more))
    assert len(set(tmp_path.glob(".scratch/vae/*")) - finished) == 1
    before, after = undisturbed.bytes_of("vae"), place.bytes_of("vae")
    assert len(after) == 3 and after.items() > before.items()


def test_what_is_finished_is_not_trained_again(frames: Path, undisturbed: Workplace, tmp_path: Path) -> None:
    place = Workplace(tmp_path)
    place.write_params(vae_epochs=EPOCHS)
    shutil.copytree(undisturbed.root / ".scratch", tmp_path / ".scratch")
    place.run("vae", *place.vae(frames), before=NO_TRAINING)
    assert place.bytes_of("vae") == undisturbed.bytes_of("vae")


def test_after_damage_in_the_scratch_store_it_ends_with_the_same_bytes(
    frames: Path, undisturbed: Workplace, tmp_path: Path
) -> None:
    place = Workplace(tmp_path)
    place.write_params(vae_epochs=EPOCHS)
    shutil.copytree(undisturbed.root / ".scratch", tmp_path / ".scratch")
    lacking, cut = sorted(tmp_path.glob(".scratch/vae/*/results/weights.pt"))
    lacking.unlink()
    cut.write_bytes(cut.read_bytes()[: cut.stat().st_size // 2])
    said = place.run("vae", *place.vae(frames))
    assert said.count("weights.pt is not as it was written") == 2
    made = ("vae", "vae.json", "reconstructions.png")
    assert place.bytes_of(*made) == undisturbed.bytes_of(*made)


def test_a_truncated_store_is_refused_and_nothing_written(frames: Path, tmp_path: Path) -> None:
    broken = tmp_path / "frames"
    shutil.copytree(frames, broken)
    shard = max(
        (f for f in (broken / "repeat_1.zarr" / "rgb").rglob("*") if f.is_file()),
        key=lambda f: f.stat().st_size,
    )
    shard.write_bytes(shard.read_bytes()[:1000])
    place = Workplace(tmp_path)
    place.write_params()
    said = place.run("vae", *place.vae(broken), status=1)
    assert said.startswith("error: ") and "dvc repro frames" in said and "Traceback" not in said
    assert not (tmp_path / "vae").exists() and not (tmp_path / "vae.json").exists()
