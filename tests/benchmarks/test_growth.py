"""What the table of growth takes for memory."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from benchmarks.growth import peak_mib


@pytest.mark.skipif(sys.platform != "linux", reason="not run: Linux tells the peak")
def test_the_peak_of_memory_stays_after_it_was_freed() -> None:
    before = peak_mib()
    assert before is not None
    filled = np.ones(int((before + 64) * 2**20), np.uint8)
    del filled
    after = peak_mib()
    assert after is not None and after > before + 32
