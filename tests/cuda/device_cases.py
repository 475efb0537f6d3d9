"""Devices on which the tests of the device path run: Warp's CPU backend here, CUDA where there is one."""

from __future__ import annotations

import pytest

DEVICES = ("cpu", pytest.param("cuda:0", marks=pytest.mark.gpu))
