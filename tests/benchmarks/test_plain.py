"""The plain loop does the same task as ours: same controller, episode and weights, same return."""

from __future__ import annotations

from functools import partial

import mujoco
import numpy as np
import pytest
import torch

from benchmarks.loops import VIEWS, Setting, candidates, setting
from benchmarks.plain_loop import AS_IT_COMES, STRIPPED, Draw, PlainLoop, renderer
from benchmarks.plain_processes import Crew
from pipeline.contract.errors import BelvedereError
from pipeline.control.loop import Loop, Workers
from pipeline.control.policy import Controllers
from pipeline.learning.device import Compute
from pipeline.rendering.renderer import Renderer
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.worldmodel.encoder import Encoder

FRAMES, EPISODES = 6, 3
SAME_PICTURES_M = 1e-4  # of a return, at batch 1 instead of 32
OTHER_PICTURES_M = 1e-2  # the two renderers differ by a level here and there, and at edges
MOVED_M = 0.05  # how much the controllers change a return, at least: the tolerances are far below it


def ours(chosen: Setting, flat: np.ndarray, episodes: Episodes) -> np.ndarray:
    encoder = Encoder(chosen.vae, Compute(torch.device("cpu"), torch.float32))
    loop = Loop(Workers(chosen.scene, chosen.view, 1), encoder, chosen.rnn)
    return loop.run(Controllers.of(flat, chosen.scene.action_size), episodes).returns


def ray_traced(chosen: Setting, model: mujoco.MjModel) -> Draw:
    """Our pictures of the plain loop's states."""
    images, target = Renderer(chosen.scene, chosen.view, 1), chosen.scene.target_mocap
    return lambda data: images.render(data.qpos[None], data.mocap_pos[target][None])[0]


def plain(chosen: Setting, loop: PlainLoop, flat: np.ndarray, episodes: Episodes) -> list[float]:
    return [loop.run(flat[i], episodes[i : i + 1]) for i in range(len(episodes))]


@pytest.mark.parametrize("scene", VIEWS)
def test_fed_the_same_pictures_it_reaches_the_same_return(scene: str) -> None:
    chosen = setting(scene, FRAMES)
    episodes = draw_episodes(chosen.scene, EPISODES, np.random.default_rng(3))
    flat = 3 * candidates(chosen.scene, EPISODES)
    expected = ours(chosen, flat, episodes)
    assert np.abs(expected - ours(chosen, 0 * flat, episodes)).max() > MOVED_M
    found = plain(chosen, PlainLoop(chosen, partial(ray_traced, chosen)), flat, episodes)
    np.testing.assert_allclose(found, expected, atol=SAME_PICTURES_M)


@pytest.mark.egl
def test_processes_with_mujocos_renderers_reach_the_same_return_but_for_the_pictures() -> None:
    chosen = setting("panda_2dof", FRAMES)
    episodes = draw_episodes(chosen.scene, EPISODES, np.random.default_rng(3))
    flat = 3 * candidates(chosen.scene, EPISODES)
    crew = Crew("panda_2dof", (STRIPPED, AS_IT_COMES), 2, FRAMES)
    try:
        stripped = crew.run(STRIPPED, flat, episodes)
        as_it_comes = crew.run(AS_IT_COMES, flat, episodes)
        again = crew.run(STRIPPED, flat, episodes)
    finally:
        crew.close()
    np.testing.assert_allclose(stripped, ours(chosen, flat, episodes), atol=OTHER_PICTURES_M)
    np.testing.assert_array_equal(stripped, again)
    assert (as_it_comes != stripped).any()  # shadows are another picture


@pytest.mark.egl
def test_the_renderer_as_it_comes_draws_shadows_and_the_stripped_one_none() -> None:
    chosen = setting("panda_2dof", 1)
    pictures = {}
    for kind in (STRIPPED, AS_IT_COMES):
        model = chosen.scene.model.__copy__()
        data = mujoco.MjData(model)
        draw = renderer(model, kind)
        mujoco.mj_forward(model, data)
        pictures[kind] = draw(data).astype(int)
    darker = (pictures[AS_IT_COMES].sum(axis=2) < pictures[STRIPPED].sum(axis=2) - 30).mean()
    assert darker > 0.01


def test_a_killed_process_is_told_in_a_sentence() -> None:
    crew = Crew("panda_1dof", (), 1, 2)
    (process,) = crew._processes
    process.kill()
    process.join()
    with pytest.raises(BelvedereError, match="at work on plain loops was killed from outside"):
        crew.run("none", np.zeros((1, 1)), Episodes.at(np.zeros((1, 3)), np.zeros((1, 3))))
