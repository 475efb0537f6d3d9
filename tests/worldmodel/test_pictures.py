"""Pictures as they are read; folding them: torch's own order, and back."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
import torch
import torch.nn.functional as F

from pipeline.contract import memory
from pipeline.contract.errors import BelvedereError
from pipeline.storage import zarrs
from pipeline.worldmodel.pictures import blocks, floats, fold, folded, read_pictures, require_pictures, unfold
from tests.stores import random_frames

BYTES = np.random.default_rng(1).integers(0, 256, (3, 64, 64, 3), dtype=np.uint8)


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> zarrs.Store:
    return random_frames(tmp_path_factory.mktemp("frames"), 100, 12)


def test_folding_is_torchs_pixel_unshuffle() -> None:
    expected = F.pixel_unshuffle(torch.from_numpy(BYTES).permute(0, 3, 1, 2).float() / 255, 2)
    torch.testing.assert_close(floats(fold(BYTES)), expected)


def test_unfolding_gives_the_bytes_back() -> None:
    assert np.array_equal(unfold(floats(fold(BYTES))), BYTES)


def test_blocks_hold_four_by_four_pixels_and_are_a_view() -> None:
    numbers = floats(fold(BYTES))
    blocked = blocks(numbers)
    expected = F.pixel_unshuffle(torch.from_numpy(BYTES).permute(0, 3, 1, 2).float() / 255, 4)
    torch.testing.assert_close(blocked.flatten(3).sort(3).values, expected.permute(0, 2, 3, 1).sort(3).values)
    assert blocked.untyped_storage().data_ptr() == numbers.untyped_storage().data_ptr()
    assert torch.equal(folded(blocked), numbers)


@pytest.mark.parametrize(("stride", "episodes"), [(1, (0, 40)), (5, (0, 90)), (5, (90, 100)), (12, (63, 66))])
def test_what_is_read_is_every_so_manieth_picture(
    store: zarrs.Store, stride: int, episodes: tuple[int, int]
) -> None:
    whole = store.repeat("rgb", 0)[slice(*episodes), ::stride].reshape(-1, 64, 64, 3)
    tracemalloc.start()
    found = read_pictures(store, 0, np.arange(*episodes), stride)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    np.testing.assert_array_equal(found, whole)
    assert peak < whole.nbytes + store.repeat("rgb", 0).nbytes / 2


def test_the_stride_that_is_said_to_fit_fits(store: zarrs.Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """100 episodes of 12 frames, two repeats at a time: 12 MiB hold two pictures of each episode, twice."""
    monkeypatch.setattr(memory, "available_bytes", lambda system: 12 * 2**20)
    with pytest.raises(BelvedereError, match=r"vae\.frame_stride = 5, .* 2 repeat.* from 6 up it fits"):
        require_pictures(store, 5, 2)
    require_pictures(store, 6, 2)
    monkeypatch.setattr(memory, "available_bytes", lambda system: 2**20)
    with pytest.raises(BelvedereError, match=r"lower rollouts\.episodes"):
        require_pictures(store, 12, 2)
