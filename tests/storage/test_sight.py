"""What a judge sees, by errors of probes against those of guessing."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.storage.sight import read_sight

GUESS = {"guess_tip_m": 0.2, "guess_target_m": 0.2, "guess_tip_to_target_m": 0.3}


def written(path: Path, *probes: tuple[float, float, float]) -> Path:
    """``vae.json`` with a row per (tip, target, tip - target)."""
    names = ("probe_mlp_tip_m", "probe_mlp_target_m", "probe_mlp_tip_to_target_m")
    rows = [{"repeat": r, **dict(zip(names, p, strict=True)), **GUESS} for r, p in enumerate(probes)]
    path.write_text(json.dumps({"repeats": rows}))
    return path


@pytest.mark.parametrize(
    ("probe", "misses"),
    [
        ((0.02, 0.03, 0.04), []),
        ((0.19, 0.03, 0.15), []),  # a half of what guessing gives is still seen
        ((0.19, 0.03, 0.2), ["tip"]),
        ((0.03, 0.19, 0.2), ["target"]),
        ((0.18, 0.19, 0.29), ["tip", "target"]),
        ((0.1, 0.1, 0.16), ["tip - target"]),
    ],
)
def test_what_the_code_lacks(tmp_path: Path, probe: tuple[float, float, float], misses: list[str]) -> None:
    found = read_sight(written(tmp_path / "vae.json", probe, probe), "desk-a", 2, 0.5)
    assert found.misses == misses
    assert (found.probe_m, found.guess_m) == (pytest.approx(probe[2]), pytest.approx(0.3))


def test_only_the_first_repeats_count(tmp_path: Path) -> None:
    seen, unseen = (0.02, 0.03, 0.04), (0.3, 0.3, 0.4)
    path = written(tmp_path / "vae.json", seen, seen, unseen, unseen, unseen)
    assert read_sight(path, "desk-a", 2, 0.5).misses == []
    assert read_sight(path, "desk-a", 5, 0.5).misses == ["tip", "target"]


def test_a_number_that_is_lacking_is_named(tmp_path: Path) -> None:
    path = written(tmp_path / "vae.json", (0.02, 0.03, 0.04))
    with pytest.raises(
        BelvedereError, match=r"vae\.json cannot be used: of its first 2 .*dvc repro vae@desk-a"
    ):
        read_sight(path, "desk-a", 2, 0.5)
    path.write_text(json.dumps({"repeats": [{"repeat": 0, "probe_mlp_tip_m": 0.1}]}))
    with pytest.raises(BelvedereError, match="how well a probe and a guess tell tip"):
        read_sight(path, "desk-a", 1, 0.5)
