from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from pipeline.contract.viewpoints import viewpoint
from pipeline.control.anchors import expert, play
from pipeline.control.clip import write_clip
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds, target_paths


def test_a_clip_shows_every_frame_beside_what_the_world_model_sees(scene: Scene, tmp_path: Path) -> None:
    worlds, episodes = Worlds(scene, 1), draw_episodes(scene, 1, np.random.default_rng(1))
    qpos = []
    act = expert(scene)

    def watched(worlds: Worlds, frame: int) -> np.ndarray:
        qpos.append(worlds.qpos[0])
        return act(worlds, frame)

    play(worlds, episodes, watched)
    paths = [tmp_path / "a.webp", tmp_path / "b.webp"]
    for path in paths:
        targets = target_paths(scene, episodes)[0, :-1]
        write_clip(path, scene, viewpoint(scene.name, 0, 0), np.stack(qpos), targets)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with Image.open(paths[0]) as clip:
        assert (clip.n_frames, clip.width) == (scene.frames, 2 * clip.height)
        large, small = np.split(np.asarray(clip.convert("RGB"), dtype=float), 2, axis=1)
    assert np.abs(large - small).mean() < 20  # the same picture, once sharp and once coarse
    red = small[..., 0] - small[..., 1:].max(axis=-1)
    assert red.max() > 50  # the target
