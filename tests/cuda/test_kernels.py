"""Our kernels compile for CUDA: Warp brings NVIDIA's compiler, which needs no GPU."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import mujoco
import numpy as np
import pytest
import warp as wp

from pipeline.cuda import arm_controllers, ik, worlds
from pipeline.rendering import buffers, bvh, ray_packets, raytracer, shading
from tests.sim.conftest import compiled

HOPPER = 90  # compute capability 9.0: H100 and H200
MODULES = (raytracer, shading, ik, arm_controllers, worlds)


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


@wp.func_native(bvh._QUERY.replace("defined(__CUDA_ARCH__)", "1"))
def intersect_mesh_as_on_cuda(
    mesh_id: wp.uint64,
    triangles: wp.array2d[float],
    first_triangle: int,
    origin: wp.vec3,
    rotation: wp.mat33,
    rays: wp.array2d[float],
    world: int,
    packet: int,
    slot: int,
    distances: wp.array2d[float],
    slots: wp.array2d[int],
    faces: wp.array2d[int],
    us: wp.array2d[float],
    vs: wp.array2d[float],
) -> float:
    """What :func:`pipeline.rendering.bvh.intersect_mesh` is on CUDA, on the CPU: each ray alone."""


@wp.kernel
def intersect(
    as_on_cuda: bool,
    mesh: wp.uint64,
    triangles: wp.array2d[float],
    origin: wp.vec3,
    rays: wp.array2d[float],
    distances: wp.array2d[float],
    slots: wp.array2d[int],
    faces: wp.array2d[int],
    us: wp.array2d[float],
    vs: wp.array2d[float],
) -> None:
    packet, rotation = wp.tid(), wp.identity(n=3, dtype=float)
    if as_on_cuda:
        intersect_mesh_as_on_cuda(
            mesh, triangles, 0, origin, rotation, rays, 0, packet, 7, distances, slots, faces, us, vs
        )
    else:
        bvh.intersect_mesh(
            mesh, triangles, 0, origin, rotation, rays, 0, packet, 7, distances, slots, faces, us, vs
        )


@pytest.mark.parametrize("inside", [False, True])
def test_rays_meet_alone_what_they_meet_in_packets(inside: bool) -> None:
    """CUDA takes another way through a mesh than the CPU; both must see the same, and pass over backs."""
    model, packs = compiled("panda_2dof").model, 64
    geom = int(np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)[-1])
    points = buffers._faces(model, int(model.geom_dataid[geom]))[0]
    middle, size = points.mean(axis=0), np.ptp(points, axis=0).max()
    origin = middle + (0.0 if inside else size) * np.array([1.0, 1.5, 0.5])
    aims = middle + 0.4 * size * np.random.default_rng(1).uniform(-1, 1, (packs * ray_packets.LANES, 3))
    directions = (aims - origin) / np.linalg.norm(aims - origin, axis=1, keepdims=True)
    found = []
    with wp.ScopedDevice("cpu"):
        mesh, triangles = (
            buffers._mesh(model, int(model.geom_dataid[geom])),
            buffers.geom_arrays(model, [geom])[1],
        )
        rays = wp.array(directions.T, dtype=float)
        for as_on_cuda in (True, False):
            distance = wp.full((1, rays.shape[1]), raytracer.FAR_M, dtype=float)
            slot, face = (wp.full(distance.shape, -1, dtype=int) for _ in range(2))
            u, v = (wp.zeros(distance.shape, dtype=float) for _ in range(2))
            outputs = [distance, slot, face, u, v]
            wp.launch(
                intersect,
                dim=packs,
                inputs=[as_on_cuda, mesh.id, triangles, wp.vec3(*origin), rays],
                outputs=outputs,
            )
            found.append([array.numpy()[0] for array in outputs])
    alone, packed = found
    hit = alone[1] == 7
    assert inside or 0.1 < hit.mean() < 0.9
    np.testing.assert_array_equal(alone[1], packed[1])
    np.testing.assert_allclose(alone[0], packed[0], rtol=1e-4)
    same = hit & (alone[2] == packed[2])
    assert same.sum() >= 0.98 * hit.sum()  # a ray on an edge may take either face
    for ours, theirs in zip(alone[3:], packed[3:], strict=True):
        np.testing.assert_allclose(ours[same], theirs[same], atol=2e-3)
