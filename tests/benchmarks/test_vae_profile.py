"""What bounds VAE training: counts against a closed form, and a split that leaves nothing out."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.vae import ours, peer
from benchmarks.vae_profile import ADAM, PARTS, REST, bound_row, operations_a_picture, part_of, split_row
from pipeline.learning.device import set_up_torch

PICTURES = np.random.default_rng(1).integers(0, 256, (64, 64, 64, 3), dtype=np.uint8)


def multiplications() -> dict[str, int]:
    """Of one picture forwards, by layer of the published network: places × weights that meet in each."""
    encoder = {"conv1": (31, 3, 32), "conv2": (14, 32, 64), "conv3": (6, 64, 128), "conv4": (2, 128, 256)}
    decoder = {
        "deconv1": (1, 1024, 128, 5),
        "deconv2": (5, 128, 64, 5),
        "deconv3": (13, 64, 32, 6),
        "deconv4": (30, 32, 3, 6),
    }
    counts = {name: side**2 * i * o * 4**2 for name, (side, i, o) in encoder.items()}
    counts |= {name: side**2 * i * o * k**2 for name, (side, i, o, k) in decoder.items()}
    return counts | {"mean": 1024 * 32, "log_variance": 1024 * 32, "decoder_input": 32 * 1024}


def test_operations_are_those_of_the_layers() -> None:
    counts = multiplications()
    # backwards as often for the weights and for the input, which the pictures themselves do not need
    expected = 2 * (3 * sum(counts.values()) - counts["conv1"])
    assert operations_a_picture(peer(PICTURES, 1)[1], 64) == pytest.approx(expected)


def test_what_is_reached_is_a_share_of_the_bound() -> None:
    row = bound_row("ours", set_up_torch(), mflop=200.0, rate=4e11, reached=500.0)
    assert (row["so at most pictures/s"], row["reached %"]) == (2000.0, 25.0)


def test_each_operation_counts_towards_one_part() -> None:
    parts = [*dict.fromkeys(PARTS.values()), ADAM]
    for form, make in (("published", peer), ("ours", ours)):
        row = split_row(form, make(PICTURES, 1)[1], 64)
        assert sum(row[part] for part in parts) == pytest.approx(row["all"])
        assert min(row[part] for part in parts) > 0
    assert part_of("aten::mkldnn_convolution") == part_of("aten::convolution_backward") == "convolution"
    assert (part_of("aten::addmm"), part_of("aten::copy_")) == ("matrix product", "copy and cast")
    assert part_of("aten::relu") == REST
