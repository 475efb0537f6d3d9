"""Folding pictures: torch's own order, and back."""

from __future__ import annotations

import numpy as np
import torch
import torch.nn.functional as F

from pipeline.worldmodel.pictures import blocks, floats, fold, folded, unfold

BYTES = np.random.default_rng(1).integers(0, 256, (3, 64, 64, 3), dtype=np.uint8)


def test_folding_is_torchs_pixel_unshuffle() -> None:
    wished = F.pixel_unshuffle(torch.from_numpy(BYTES).permute(0, 3, 1, 2).float() / 255, 2)
    torch.testing.assert_close(floats(fold(BYTES)), wished)


def test_unfolding_gives_the_bytes_back() -> None:
    assert np.array_equal(unfold(floats(fold(BYTES))), BYTES)


def test_blocks_hold_four_by_four_pixels_and_are_a_view() -> None:
    numbers = floats(fold(BYTES))
    blocked = blocks(numbers)
    wished = F.pixel_unshuffle(torch.from_numpy(BYTES).permute(0, 3, 1, 2).float() / 255, 4)
    torch.testing.assert_close(blocked.flatten(3).sort(3).values, wished.permute(0, 2, 3, 1).sort(3).values)
    assert blocked.untyped_storage().data_ptr() == numbers.untyped_storage().data_ptr()
    assert torch.equal(folded(blocked), numbers)
