"""Pictures against MuJoCo's own renderer, mujoco_warp's ray tracer and MuJoCo's rays."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache

import mujoco
import mujoco_warp as mjw
import numpy as np
import pytest
import warp as wp

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.buffers import static_geoms
from pipeline.rendering.renderer import ParallelRenderer, Renderer, model_seen_from, target_pixels_unhidden
from pipeline.rendering.visibility import PICTURE_SIZE, Sight
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import CAMERA, Scene
from pipeline.sim.worlds import Worlds
from tests.sim.conftest import SCENES, VIEWS, compiled

FIRST_VIEWS = {view.scene: view for view in reversed(VIEWS)}
STATES = 8
STEPS = 12


@cache
def states(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Generalised positions and targets of random rollouts, some steps in."""
    scene, rng = compiled(name), np.random.default_rng(7)
    worlds = Worlds(scene, STATES)
    worlds.reset(draw_episodes(scene, STATES, rng))
    direction = rng.uniform(-1, 1, (STATES, scene.action_size))
    for _ in range(STEPS):
        worlds.step(np.clip(direction + rng.normal(0, 0.3, direction.shape), -1, 1))
    return worlds.qpos, worlds.target


def difference(ours: np.ndarray, theirs: np.ndarray) -> tuple[float, float]:
    """Mean absolute error in levels, and the share of pixels that are off by more than 16."""
    error = np.abs(ours.astype(int) - theirs)
    return float(error.mean()), float((error.max(axis=-1) > 16).mean())


def mujoco_pictures(scene: Scene, view: Viewpoint, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
    """By OpenGL, without what the ray tracer leaves out: shadows, reflections, multisampling."""
    model = model_seen_from(scene, view)
    model.vis.quality.offsamples = model.vis.quality.shadowsize = 0
    data, pictures = mujoco.MjData(model), []
    with mujoco.Renderer(model, PICTURE_SIZE, PICTURE_SIZE) as renderer:
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            renderer.scene.flags[flag] = 0
        for q, target in zip(qpos, target_m, strict=True):
            data.qpos, data.mocap_pos[scene.target_mocap] = q, target
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, CAMERA)
            pictures.append(renderer.render().copy())
    return np.stack(pictures)


def warp_pictures(scene: Scene, view: Viewpoint, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
    """By mujoco_warp's own ray tracer."""
    model, n = model_seen_from(scene, view), len(qpos)
    with wp.ScopedDevice("cpu"):
        on_device, data = mjw.put_model(model), mjw.make_data(model, nworld=n, nconmax=1, njmax=1)
        context = mjw.create_render_context(
            model,
            nworld=n,
            cam_res=(PICTURE_SIZE, PICTURE_SIZE),
            render_rgb=True,
            use_textures=False,
            cam_active=[CAMERA],
            background_color=(*scene.params.light.background_rgb, 1.0),
            enable_backface_culling=False,
        )
        data.qpos.numpy()[:], data.mocap_pos.numpy()[:, scene.target_mocap] = qpos, target_m
        mjw.kinematics(on_device, data)
        mjw.camlight(on_device, data)
        mjw.refit_bvh(on_device, data, context)
        mjw.render(on_device, data, context)
    packed = context.rgb_data.numpy().view(np.uint8).reshape(n, PICTURE_SIZE, PICTURE_SIZE, 4)
    return packed[..., 2::-1]  # packed as blue, green, red, alpha


@pytest.mark.egl
def test_like_mujocos_renderer(view: Viewpoint) -> None:
    scene, (qpos, target) = compiled(view.scene), states(view.scene)
    mean, off = difference(
        Renderer(scene, view, STATES).render(qpos, target), mujoco_pictures(scene, view, qpos, target)
    )
    assert mean < 0.7  # 0.12 to 0.51: colours are cut off, not rounded, to whole levels
    assert off < 0.004  # 0.0002 to 0.0019: edges


@pytest.mark.parametrize("name", SCENES)
def test_like_mujoco_warp(name: str) -> None:
    scene, view, (qpos, target) = compiled(name), FIRST_VIEWS[name], states(name)
    mean, off = difference(
        Renderer(scene, view, STATES).render(qpos, target), warp_pictures(scene, view, qpos, target)
    )
    assert mean < 0.01
    assert off < 1e-4


def test_sees_as_many_target_pixels_as_mujocos_rays(view: Viewpoint) -> None:
    scene, (qpos, target) = compiled(view.scene), states(view.scene)
    images = Renderer(scene, view, STATES, segment=True)
    images.render(qpos, target)
    counted = images.target_pixels(STATES)
    assert np.abs(counted - Sight(scene, STATES).target_pixels(view, qpos, target)).max() <= 1
    assert (counted <= target_pixels_unhidden(scene, view, qpos, target)).all()
    assert counted.max() > 0


def test_a_picture_depends_on_its_world_alone(view: Viewpoint) -> None:
    scene, (qpos, target) = compiled(view.scene), states(view.scene)
    together = Renderer(scene, view, STATES)
    pictures = together.render(qpos, target).copy()
    np.testing.assert_array_equal(together.render(qpos[::-1], target[::-1])[::-1], pictures)
    np.testing.assert_array_equal(together.render(qpos[:3], target[:3]), pictures[:3])
    alone = Renderer(scene, view, 1)
    for i in range(STATES):
        np.testing.assert_array_equal(alone.render(qpos[i : i + 1], target[i : i + 1])[0], pictures[i])


@pytest.mark.parametrize("name", SCENES)
def test_threads_draw_what_one_draws(name: str) -> None:
    scene, view, (qpos, target) = compiled(name), FIRST_VIEWS[name], states(name)
    expected = Renderer(scene, view, STATES).render(qpos, target).copy()
    workers = [Renderer(scene, view, STATES) for _ in range(4)]
    with ThreadPoolExecutor(len(workers)) as pool:
        for _ in range(5):
            for pictures in pool.map(lambda worker: worker.render(qpos, target).copy(), workers):
                np.testing.assert_array_equal(pictures, expected)


def test_the_parallel_renderer_draws_any_number() -> None:
    view = VIEWS[-1]
    scene, (qpos, target) = compiled(view.scene), states(view.scene)
    qpos, target = np.tile(qpos, (9, 1))[:70], np.tile(target, (9, 1))[:70]
    drawn: list[int] = []
    pictures, pixels = ParallelRenderer(scene, view, 2, segment=True).render(qpos, target, drawn.append)
    assert sum(drawn) == 70
    images = Renderer(scene, view, 70, segment=True)
    np.testing.assert_array_equal(pictures, images.render(qpos, target))
    np.testing.assert_array_equal(pixels, images.target_pixels(70))


def test_unhidden_pixels_are_the_same_in_any_batch() -> None:
    view = VIEWS[-1]
    scene, (qpos, target) = compiled(view.scene), states(view.scene)
    qpos, target = np.tile(qpos, (9, 1))[:70], np.tile(target, (9, 1))[:70]
    found = target_pixels_unhidden(scene, view, qpos, target)
    alone = [target_pixels_unhidden(scene, view, qpos[i : i + 1], target[i : i + 1])[0] for i in range(70)]
    assert found.tolist() == alone and found.all()


@pytest.mark.parametrize("size", [30, 64])
def test_antialiased_pixels_are_means(size: int) -> None:
    view = VIEWS[-1]
    scene, (qpos, target) = compiled(view.scene), states(view.scene)
    smooth = Renderer(scene, view, STATES, size=size, antialias=3).render(qpos, target)
    fine = Renderer(scene, view, STATES, size=3 * size).render(qpos, target).astype(float)
    mean = fine.reshape(STATES, size, 3, size, 3, 3).mean(axis=(2, 4))
    assert np.abs(smooth - mean).max() <= 1.0


def test_what_locked_joints_hold_stands_still() -> None:
    model = compiled("fetch_reach").model
    names = [model.body(body).name.removeprefix("robot0:") for body in model.geom_bodyid]
    stands = dict(zip(names, static_geoms(model, np.arange(model.ngeom)), strict=True))
    assert stands["base_link"] and stands["torso_fixed_link"] and stands["table0"]
    assert not stands["torso_lift_link"] and not stands["gripper_link"] and not stands["target"]


PRIMITIVES = """
<mujoco>
  <visual><headlight ambient=".3 .3 .3" diffuse=".4 .4 .4" specular="0 0 0"/></visual>
  <worldbody>
    <light type="directional" dir="0 0 -1" diffuse=".3 .3 .3" specular="0 0 0"/>
    <camera name="viewpoint" fovy="40"/>
    <geom type="plane" size="1 1 .1" rgba=".5 .6 .4 1"/>
    <geom type="cylinder" pos=".4 -.2 .1" size=".05 .1" rgba=".2 .4 .8 1"/>
    <geom type="box" pos=".5 0 .3" size=".1 .1 .1" rgba="0 0 0 0"/>
    <body pos=".5 0 .2"><joint name="a" axis="1 0 1"/>
      <geom type="capsule" pos="0 .1 0" size=".03 .08" rgba=".9 .3 .1 1"/>
      <geom type="ellipsoid" pos="0 -.1 0" size=".03 .05 .08" rgba=".1 .9 .3 1"/>
      <geom type="cylinder" pos="0 0 .12" size=".05 .02" rgba=".8 .8 .1 1"/>
      <geom type="box" pos=".1 0 -.05" size=".05 .02 .03" rgba=".7 .2 .7 1"/>
    </body>
    <body name="target" mocap="true"><geom name="target" size=".04" group="1" rgba="1 0 0 1"/></body>
  </worldbody>
</mujoco>"""


def with_model(xml: str) -> Scene:
    scene = compiled("panda_2dof")
    return replace(scene, model=mujoco.MjModel.from_xml_string(xml), robot=replace(scene.robot, home={}))


@pytest.mark.parametrize("theta", [0.0, 35.0])
def test_primitives_like_mujoco_warp(theta: float) -> None:
    scene, view = with_model(PRIMITIVES), Viewpoint(scene="panda_2dof", theta=theta, phi=25)
    qpos = np.linspace(0, 3, STATES)[:, None]
    target = np.random.default_rng(3).uniform([0.4, -0.2, 0.1], [0.6, 0.2, 0.4], (STATES, 3))
    ours, theirs = (
        Renderer(scene, view, STATES).render(qpos, target),
        warp_pictures(scene, view, qpos, target),
    )
    mean, off = difference(ours, theirs)
    assert mean < 0.01
    assert off < 1e-4
    assert len(np.unique(ours.reshape(-1, 3), axis=0)) > 50  # something is in the picture


@pytest.mark.parametrize(
    ("text", "instead", "message"),
    [
        (
            'type="directional" dir',
            'type="spot" name="lamp" dir',
            "light lamp of the scene is not directional",
        ),
        (
            '<geom type="plane" size="1 1 .1"',
            '<geom name="hill" type="hfield" hfield="h"',
            "geom hill of the scene is a mjGEOM_HFIELD",
        ),
    ],
)
def test_what_cannot_be_drawn_is_named(text: str, instead: str, message: str) -> None:
    asset = "<worldbody>", '<asset><hfield name="h" nrow="4" ncol="4" size="1 1 1 .1"/></asset><worldbody>'
    scene = with_model(PRIMITIVES.replace(text, instead).replace(*asset))
    with pytest.raises(BelvedereError, match=message):
        Renderer(scene, Viewpoint(scene="panda_2dof", theta=0, phi=0), 1)
