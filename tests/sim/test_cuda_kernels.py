"""Our kernels compile for CUDA: Warp brings NVIDIA's compiler, which needs no GPU."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest
import warp as wp

from pipeline.sim import device_drives, device_ik, device_worlds, painting, raytracer

HOPPER = 90  # compute capability 9.0: H100 and H200
MODULES = (raytracer, painting, device_ik, device_drives, device_worlds)


def kernels(module: ModuleType) -> set[str]:
    return {name for name, value in vars(module).items() if isinstance(value, wp.Kernel)}


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__.rsplit(".", 1)[-1])
def test_a_module_compiles_for_cuda(module: ModuleType, tmp_path: Path) -> None:
    if HOPPER not in wp.get_cuda_supported_archs():
        pytest.skip("not run: this build of Warp has no CUDA compiler")
    assert kernels(module)
    (made,) = wp.compile_aot_module(module, arch=HOPPER, module_dir=tmp_path, use_ptx=True)
    ptx = made.read_text()
    entries = {
        line.split()[2].split("(")[0] for line in ptx.splitlines() if line.startswith(".visible .entry")
    }
    for name in kernels(module):
        assert any(entry.startswith(f"{name}_") for entry in entries), (name, entries)
