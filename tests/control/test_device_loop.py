"""The closed loop on a device against the one on the CPU: the same episodes within a stated tolerance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import torch

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import viewpoint
from pipeline.control import loops
from pipeline.control.device_loop import DeviceLoop
from pipeline.control.jobs import Job
from pipeline.control.loop import Trace
from pipeline.control.loops import HostLoops, closed_loops
from pipeline.control.policy import parameters
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene, load_scene
from tests.control.conftest import untrained
from tests.cuda.device_cases import DEVICES
from tests.sim.conftest import SCENES

CPU = torch.device("cpu")
FIELDS = ("qpos", "tip_m", "action", "reward")
# Of an episode of 50 frames, m; mujoco_warp's float32 makes most of it, in Fetch more than in the Panda.
RETURN_M = {"panda": 1e-3, "fetch": 1e-2}


@pytest.fixture(autouse=True)
def _no_tf32(monkeypatch: pytest.MonkeyPatch) -> None:
    """CUDA's convolutions in float32 are float32: what is compared is the loop."""
    monkeypatch.setattr(torch.backends.cudnn, "allow_tf32", False)


def jobs(scene: Scene, candidates: int, episodes: int, members: Sequence[int] = (1, 0)) -> list[Job]:
    rng = np.random.default_rng(2)
    flat = 0.3 * rng.standard_normal((candidates, parameters(scene.action_size)))
    return [Job.of(member, flat, draw_episodes(scene, episodes, rng)) for member in members]


def run(scene: Scene, device: str, asked: list[Job]) -> list[Trace]:
    place = torch.device(device)
    return DeviceLoop(scene, viewpoint(scene.name, 0, 0), untrained(scene.action_size, place), place).run(
        asked
    )


@pytest.mark.parametrize("device", DEVICES)
def test_each_job_is_run_as_on_the_cpu(scene: Scene, device: str) -> None:
    asked = jobs(scene, candidates=2, episodes=2)
    host = HostLoops(scene, viewpoint(scene.name, 0, 0), untrained(scene.action_size, CPU), threads=1)
    for found, expected in zip(run(scene, device, asked), host.run(asked), strict=True):
        for name in FIELDS:
            ours, theirs = getattr(found, name), getattr(expected, name)
            assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype)
            np.testing.assert_allclose(ours, theirs, atol=1e-4 if device == "cpu" else 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("name", SCENES)
def test_whole_episodes_return_what_they_do_on_the_cpu(name: str, device: str) -> None:
    scene = load_scene(name)
    asked = jobs(scene, candidates=2, episodes=2, members=(0,))
    host = HostLoops(scene, viewpoint(name, 0, 0), untrained(scene.action_size, CPU), threads=2)
    found, expected = run(scene, device, asked)[0], next(host.run(asked))
    assert np.ptp(expected.returns) > 0.1
    np.testing.assert_allclose(found.returns, expected.returns, atol=RETURN_M[scene.params.robot])


def test_a_job_has_the_same_bytes_alone_and_beside_others(scene: Scene) -> None:
    asked = jobs(scene, candidates=2, episodes=2)
    together = run(scene, "cpu", asked)
    for index, job in enumerate(asked):
        alone = run(scene, "cpu", [job])[0]
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(together[index], name), getattr(alone, name))


def test_a_call_leaves_nothing_to_the_next(scene: Scene) -> None:
    device_loop = DeviceLoop(scene, viewpoint(scene.name, 0, 0), untrained(scene.action_size, CPU), CPU)
    first, other = jobs(scene, candidates=1, episodes=2), jobs(scene, candidates=2, episodes=2, members=(0,))
    found = [device_loop.run(first), device_loop.run(other), device_loop.run(first)]
    for before, after in zip(found[0], found[2], strict=True):
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(before, name), getattr(after, name))


@pytest.mark.parametrize("device", DEVICES)
def test_a_controller_that_gives_no_numbers_is_told(scene: Scene, device: str) -> None:
    flat = np.full((1, parameters(scene.action_size)), np.nan)
    broken = Job.of(0, flat, draw_episodes(scene, 2, np.random.default_rng(1)))
    with pytest.raises(BelvedereError, match="not a number"):
        run(scene, device, [broken])


def test_the_device_decides_which_loop_runs(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    view, cuda = viewpoint(scene.name, 0, 0), torch.device("cuda")
    monkeypatch.setattr(loops, "DeviceLoop", lambda *given: given)
    assert isinstance(closed_loops(scene, view, [], CPU, 1), HostLoops)
    assert closed_loops(scene, view, [], cuda, 1) == (scene, view, [], cuda)
