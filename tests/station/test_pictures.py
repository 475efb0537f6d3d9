"""Pictures that are not square, against the pipeline's renderer and MuJoCo's; and what is chosen."""

from __future__ import annotations

import io

import mujoco
import numpy as np
import pytest
from PIL import Image

from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import Renderer, model_seen_from
from pipeline.sim.scene import CAMERA, Scene, load_scene
from pipeline.station import pictures
from pipeline.station.bands import RayTracer
from pipeline.station.messages import JPEG, picture_header, picture_message
from pipeline.station.opengl import MujocoRenderer
from pipeline.station.pictures import Choice, choose, encoded
from pipeline.station.world import World

SIZE = (160, 128)


def placed(name: str) -> World:
    scene = load_scene(name)
    world, rng = World(scene), np.random.default_rng(2)
    target = np.array(scene.params.target.candidates_m[0])
    world.reset(np.array([0.5, *target[1:]]) if name != "fetch_reach" else target, target)
    for _ in range(5):
        world.step(rng.uniform(-1, 1, scene.action_size))
    return world


@pytest.mark.parametrize("name, theta, phi", [("panda_2dof_obstacle", 30, 20), ("fetch_reach", 45, 30)])
@pytest.mark.parametrize("threads", [1, 3])
def test_the_middle_of_a_wide_picture_is_the_pipeline_s_square_one(
    name: str, theta: float, phi: float, threads: int
) -> None:
    world = placed(name)
    view = Viewpoint(scene=name, theta=theta, phi=phi)
    square = Renderer(world.scene, view, 1, size=SIZE[1])
    expected = square.render(world.qpos[None].astype(np.float32), world.target[None])[0]
    wide = RayTracer(world.scene, view, SIZE, threads)
    drawn = wide.draw(world.qpos, world.target)
    beside = (SIZE[0] - SIZE[1]) // 2
    assert drawn.shape == (SIZE[1], SIZE[0], 3)
    assert np.array_equal(drawn[:, beside:-beside], expected)
    wide.close()


@pytest.mark.egl
@pytest.mark.parametrize("name, theta, phi", [("panda_2dof_obstacle", 30, 20), ("panda_1dof", 90, 45)])
def test_both_renderers_draw_the_same_picture(name: str, theta: float, phi: float) -> None:
    world = placed(name)
    view = Viewpoint(scene=name, theta=theta, phi=phi)
    tracer, opengl = RayTracer(world.scene, view, SIZE, 1), MujocoRenderer(world.scene, view, SIZE, 0)
    pair = [r.draw(world.qpos, world.target).astype(int).copy() for r in (tracer, opengl)]
    assert np.mean(np.abs(pair[0] - pair[1]).max(axis=2) > 12) < 0.01
    assert np.mean(np.ptp(pair[0], axis=(0, 1))) > 50  # there is something in it
    tracer.close()
    opengl.close()


def test_the_gripper_is_seen_to_close() -> None:
    world = placed("panda_2dof")
    tracer = RayTracer(world.scene, Viewpoint(scene="panda_2dof", theta=0, phi=0), SIZE, 1)
    opened = tracer.draw(world.qpos, world.target).copy()
    world.close()
    for _ in range(15):
        world.step(np.zeros(2))
    assert not np.array_equal(opened, tracer.draw(world.qpos, world.target))
    tracer.close()


class Timed:
    """A renderer that pretends to take its time."""

    def __init__(self, name: str, size: tuple[int, int]) -> None:
        self.name, self.size = name, size

    def draw(self, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        return np.zeros((*self.size[::-1], 3), np.uint8)

    def close(self) -> None:
        """Nothing is held."""


@pytest.mark.parametrize(
    "opengl_ms, tracer_ms, wanted, expected",
    [
        ({4: 5, 0: 3}, 10, "auto", ("mujoco-egl", SIZE, 4)),
        ({4: 50, 0: 20}, 10, "auto", ("mujoco-egl", SIZE, 0)),
        ({4: 50, 0: 40}, 20, "auto", ("ray tracer", SIZE, 0)),
        ({4: 50, 0: 40}, 40, "auto", ("ray tracer", (120, 96), 0)),  # ¾ of each side take 9/16 of the time
        ({4: 50, 0: 40}, 60, "mujoco", ("mujoco-egl", SIZE, 0)),  # none is fast enough: the fastest
        ({4: 5, 0: 3}, 20, "ray tracer", ("ray tracer", SIZE, 0)),
        ({4: 900, 0: 900}, 900, "auto", ("ray tracer", (40, 32), 0)),
    ],
)
def test_what_is_fast_enough_is_chosen_in_the_order_of_quality(
    monkeypatch: pytest.MonkeyPatch,
    opengl_ms: dict[int, float],
    tracer_ms: float,
    wanted: str,
    expected: tuple[str, tuple[int, int], int],
) -> None:
    scene = load_scene("panda_1dof")
    times: dict[int, float] = {}

    def opengl(_: Scene, __: Viewpoint, size: tuple[int, int], samples: int) -> Timed:
        made = Timed("mujoco-egl", size)
        times[id(made)] = opengl_ms[samples]
        return made

    def tracer(_: Scene, __: Viewpoint, size: tuple[int, int], threads: int) -> Timed:
        made = Timed("ray tracer", size)
        times[id(made)] = tracer_ms * size[0] * size[1] / (SIZE[0] * SIZE[1])
        return made

    tracer.name = "ray tracer"  # type: ignore[attr-defined]
    monkeypatch.setattr(pictures, "MujocoRenderer", opengl)
    monkeypatch.setattr(pictures, "RayTracer", tracer)
    monkeypatch.setattr(pictures, "_milliseconds", lambda renderer, _: times[id(renderer)])
    view = Viewpoint(scene=scene.name, theta=0, phi=0)
    found = choose(scene, view, SIZE, wanted, 0.04, 1)  # type: ignore[arg-type]
    assert (found.name, found.size, found.samples) == expected
    assert isinstance(found, Choice)


def test_a_picture_s_message_tells_what_it_shows() -> None:
    picture = np.zeros((32, 48, 3), np.uint8)
    picture[:, 24:] = (200, 30, 30)
    message = picture_message(7, 2**32 + 5, 1234, encoded(picture))
    assert picture_header(message) == (7, 5, 1234, JPEG)
    drawn = np.asarray(Image.open(io.BytesIO(message[16:])))
    assert drawn.shape == picture.shape and np.abs(drawn.astype(int) - picture).mean() < 5


def test_the_vertical_field_of_view_is_that_of_the_scene() -> None:
    """The target's centre is drawn where a pinhole camera of the scene's field of view has it."""
    world = placed("panda_2dof")
    view = Viewpoint(scene="panda_2dof", theta=20, phi=10)
    tracer = RayTracer(world.scene, view, SIZE, 1)
    aside = world.target + np.array([0, 0, 0.05])
    drawn = tracer.draw(world.qpos, aside).astype(int)
    red = (drawn[..., 0] > 120) & (drawn[..., 1] < 80) & (drawn[..., 2] < 80)
    rows, columns = np.nonzero(red)
    model = model_seen_from(world.scene, view)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = model.camera(CAMERA).id
    seen = data.cam_xmat[camera].reshape(3, 3).T @ (aside - data.cam_xpos[camera])
    focal = SIZE[1] / 2 / np.tan(np.radians(model.cam_fovy[camera]) / 2)
    at = np.array([SIZE[0], SIZE[1]]) / 2 - 0.5 + focal * np.array([seen[0], -seen[1]]) / -seen[2]
    assert len(rows) > 30
    assert [np.ptp(columns) / 2 + columns.min(), np.ptp(rows) / 2 + rows.min()] == pytest.approx(at, abs=4)
    tracer.close()
