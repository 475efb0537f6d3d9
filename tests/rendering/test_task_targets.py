"""The targets of all tasks in pictures: what the ray tracer counts is what MuJoCo's own rays meet."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import viewpoint
from pipeline.rendering.renderer import Renderer, target_pixels_unhidden
from pipeline.rendering.visibility import Sight, refuse_hidden_targets
from pipeline.sim.draws import draw_episodes
from pipeline.sim.expert import Expert
from pipeline.sim.worlds import Worlds
from tests.examples import KINDS, example, example_views

COUNT = 6


@pytest.mark.parametrize("letter", ["a", "b"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_pixels_of_a_target_are_those_that_rays_meet(kind: str, letter: str) -> None:
    scene, view = example(kind), example_views(kind)[f"panda_{kind}-{letter}"]
    worlds, images, sight = (
        Worlds(scene, COUNT),
        Renderer(scene, view, COUNT, segment=True),
        Sight(scene, COUNT),
    )
    worlds.reset(draw_episodes(scene, COUNT, np.random.default_rng(1)))
    expert, hidden = Expert(scene), 0
    for frame in range(30):
        if frame % 6 == 0:
            images.render(worlds.qpos, worlds.target)
            seen = images.target_pixels(COUNT)
            free = target_pixels_unhidden(scene, view, worlds.qpos, worlds.target)
            met = sight.target_pixels(view, worlds.qpos, worlds.target)
            np.testing.assert_allclose(seen, met, atol=2)  # a ray may just miss an edge
            assert (seen <= free).all() and free.min() > 5
            hidden += int((seen < free).sum())
        worlds.step(expert(worlds.state))
    assert hidden > 0 or kind == "align"  # hand or puck comes before it


@pytest.mark.parametrize("kind", KINDS)
def test_the_examples_views_show_every_target_and_one_from_below_the_desk_is_refused(kind: str) -> None:
    scene = example(kind)
    for view in example_views(kind).values():
        refuse_hidden_targets(scene, view)
    with pytest.raises(BelvedereError, match="desk hides the whole target"):
        refuse_hidden_targets(scene, viewpoint(scene.name, 0, -60))


def test_the_container_does_not_hide_itself() -> None:
    """Its walls are boxes, as obstacles are."""
    scene = example("align")
    for theta in range(0, 360, 30):
        refuse_hidden_targets(scene, viewpoint(scene.name, theta, 45))
