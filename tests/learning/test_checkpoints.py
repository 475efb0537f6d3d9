"""Torch files: the same bytes whatever their name; broken ones refused in a sentence."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from pipeline.contract.errors import BelvedereError
from pipeline.learning import checkpoints
from tests.damage import flipped


def test_the_bytes_do_not_depend_on_the_name(tmp_path: Path) -> None:
    content = {"weights": {"a": torch.arange(6.0).reshape(2, 3)}, "epoch": 3}
    checkpoints.save(tmp_path / "one.pt", content)
    checkpoints.save(tmp_path / "another.name", content)
    assert (tmp_path / "one.pt").read_bytes() == (tmp_path / "another.name").read_bytes()
    assert torch.equal(checkpoints.load(tmp_path / "one.pt", "vae")["weights"]["a"], content["weights"]["a"])


@pytest.mark.parametrize("damage", ["missing", "truncated", "foreign", "list"])
def test_a_broken_file_is_refused(tmp_path: Path, damage: str) -> None:
    path = tmp_path / "weights.pt"
    if damage == "list":
        torch.save([1, 2], path)
    elif damage != "missing":
        checkpoints.save(path, {"a": torch.ones(1000)})
        path.write_bytes(path.read_bytes()[:500] if damage == "truncated" else b"no torch file at all")
    with pytest.raises(BelvedereError, match=r"weights\.pt .*dvc repro vae"):
        checkpoints.load(path, "vae")


def test_each_flipped_bit_is_refused_or_changes_nothing(tmp_path: Path) -> None:
    path, numbers = tmp_path / "weights.pt", torch.randn(200, generator=torch.Generator().manual_seed(1))
    checkpoints.save(path, {"numbers": numbers, "epoch": 3})
    good = path.read_bytes()
    in_numbers = good.index(numbers.numpy().tobytes()) * 8
    for bit in [*range(0, 8 * len(good), 37), *range(in_numbers, in_numbers + 8 * 4 * len(numbers), 37)]:
        path.write_bytes(flipped(good, bit))
        try:
            found = checkpoints.load(path, "vae")
        except BelvedereError as error:
            assert "dvc repro vae" in str(error)
        else:
            assert torch.equal(found["numbers"], numbers) and found["epoch"] == 3
            assert not in_numbers <= bit < in_numbers + 8 * 4 * len(numbers)
