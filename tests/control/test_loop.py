from __future__ import annotations

import threading

import numpy as np
import torch
from torch import nn

from pipeline.contract.viewpoints import viewpoint
from pipeline.control.loop import SHARD, Loop, Workers
from pipeline.control.policy import Controllers, parameters
from pipeline.rendering.renderer import Renderer
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds
from pipeline.storage.stage import WORKER
from pipeline.worldmodel.mdnrnn import MdnRnn
from pipeline.worldmodel.vae import Vae

RNG = np.random.default_rng(2)


def candidates(scene: Scene, count: int) -> np.ndarray:
    return 0.3 * RNG.standard_normal((count, parameters(scene.action_size)))


def test_no_number_depends_on_how_many_threads_there_are(scene: Scene, loops: dict[int, Loop]) -> None:
    count = 2 * SHARD + 5
    episodes, flat = draw_episodes(scene, count, RNG), candidates(scene, count)
    controllers = Controllers.of(flat, scene.action_size)
    one, two = (loops[threads].run(controllers, episodes) for threads in (1, 2))
    assert one.reward.shape == (count, scene.frames)
    for name in ("qpos", "tip_m", "action", "reward"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    again = loops[1].run(controllers, episodes)  # workers keep nothing of an episode
    np.testing.assert_array_equal(one.reward, again.reward)


def test_it_does_what_one_world_in_a_plain_loop_does(
    scene: Scene, loops: dict[int, Loop], world_model: tuple[Vae, MdnRnn]
) -> None:
    vae, rnn = world_model
    cell = nn.LSTMCell(32 + scene.action_size, 256)
    cell.load_state_dict({name.removesuffix("_l0"): value for name, value in rnn.lstm.state_dict().items()})
    episodes, flat = draw_episodes(scene, 3, RNG), candidates(scene, 3)
    trace = loops[2].run(Controllers.of(flat, scene.action_size), episodes)
    worlds, images = Worlds(scene, 1), Renderer(scene, viewpoint(scene.name, 0, 0), 1)
    weight = torch.from_numpy(flat[1].astype(np.float32)).view(scene.action_size, -1)
    worlds.reset(episodes[1:2])
    h = c = torch.zeros(1, 256)
    total = 0.0
    with torch.inference_mode():
        for _ in range(scene.frames):
            picture = torch.from_numpy(images.render(worlds.qpos, worlds.target)) / 255
            z = vae.encode(picture.permute(0, 3, 1, 2))[0]
            action = torch.tanh(weight @ torch.cat([z[0], h[0], torch.ones(1)]))
            total += worlds.step(action.numpy()[None])[0]
            h, c = cell(torch.cat([z, action[None]], dim=1), (h, c))
    np.testing.assert_allclose(trace.tip_m[1, -1], worlds.tip[0], atol=1e-4)
    np.testing.assert_allclose(trace.returns[1], total, atol=1e-4)


def test_an_ending_process_does_not_wait_for_shards(scene: Scene) -> None:
    names: list[str] = []
    workers = Workers(scene, viewpoint(scene.name, 0, 0), threads=1)
    workers.start(lambda worker: names.append(threading.current_thread().name)).result()  # type: ignore[arg-type, return-value]
    assert names[0].startswith(WORKER)
