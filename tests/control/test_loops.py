"""The closed loops of several world models on the CPU."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from pipeline.contract.viewpoints import viewpoint
from pipeline.control.jobs import Job, Networks
from pipeline.control.loop import Loop, Workers
from pipeline.control.loops import HostLoops, closed_loops, mean_returns
from pipeline.control.policy import Controllers, parameters
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene

RNG = np.random.default_rng(2)


@pytest.fixture(scope="module")
def loops(scene: Scene, networks: list[Networks]) -> HostLoops:
    made = closed_loops(scene, viewpoint(scene.name, 0, 0), networks, torch.device("cpu"), threads=2)
    assert isinstance(made, HostLoops)
    return made


def candidates(scene: Scene, count: int) -> np.ndarray:
    return 0.3 * RNG.standard_normal((count, parameters(scene.action_size)))


def test_each_job_sees_through_its_own_networks_to_the_same_bytes_as_alone(
    scene: Scene, loops: HostLoops, networks: list[Networks]
) -> None:
    flat, episodes = candidates(scene, 3), draw_episodes(scene, 5, RNG)
    jobs = [Job.of(member, flat, episodes) for member in (1, 0)]
    traces = dict(zip((1, 0), loops.run(jobs), strict=True))
    assert (traces[0].action != traces[1].action).any()
    for member, trace in traces.items():
        workers = Workers(scene, viewpoint(scene.name, 0, 0), threads=1)
        loop = Loop(workers, networks[member].encoder, networks[member].rnn)
        alone = loop.run(jobs[0].controllers, jobs[0].episodes)
        for name in ("qpos", "tip_m", "action", "reward"):
            np.testing.assert_array_equal(getattr(trace, name), getattr(alone, name))


def test_every_candidate_is_judged_by_the_same_episodes(scene: Scene, loops: HostLoops) -> None:
    episodes, flat = draw_episodes(scene, 5, RNG), candidates(scene, 3)
    (together,) = mean_returns(loops, [Job.of(0, flat, episodes)], candidates=3)
    alone = [mean_returns(loops, [Job.of(0, one[None], episodes)], candidates=1)[0][0] for one in flat]
    np.testing.assert_allclose(together, alone, atol=1e-5)
    assert len(set(together)) == 3


def test_a_job_has_a_controller_for_each_episode(scene: Scene) -> None:
    controllers, episodes = (
        Controllers.of(candidates(scene, 2), scene.action_size),
        draw_episodes(scene, 3, RNG),
    )
    with pytest.raises(ValueError, match="2 controllers for 3 episodes"):
        Job(0, controllers, episodes)
