"""A small store of real frames, and a folder in which the world model's stages run on it."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import Renderer, target_pixels_unhidden
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds
from pipeline.storage import zarrs
from tests.stores import write_store

ROOT = Path(__file__).resolve().parents[2]
SCENE, THETA_DEG, PHI_DEG = "panda_2dof", 45.0, 15.0
EPISODES, FRAMES = 5, 12


def write_frames(path: Path, repeats: int) -> None:
    """Renders short random episodes; repeat r is the same however many repeats there are."""
    scene = load_scene(SCENE, ROOT / "params.yaml")
    view = Viewpoint(scene=SCENE, theta=THETA_DEG, phi=PHI_DEG)
    images = Renderer(scene, view, EPISODES * FRAMES, segment=True)
    columns: dict[str, list[np.ndarray]] = {name: [] for name in zarrs.FRAMES}
    for repeat in range(repeats):
        rng = np.random.default_rng(repeat)
        episodes, worlds = draw_episodes(scene, EPISODES, rng), Worlds(scene, EPISODES)
        worlds.reset(episodes)
        actions = rng.uniform(-1, 1, (FRAMES, EPISODES, 2))
        qpos, tip, reward = [], [], []
        for action in actions:
            qpos.append(worlds.qpos)
            tip.append(worlds.tip)
            reward.append(worlds.step(action))
        places, targets = np.stack(qpos, 1), np.repeat(episodes.target_m, FRAMES, axis=0)
        rgb = images.render(places.reshape(EPISODES * FRAMES, -1), targets)
        pixels = images.target_pixels(EPISODES * FRAMES)
        columns["rgb"].append(rgb.reshape(EPISODES, FRAMES, 64, 64, 3).copy())
        columns["tip"].append(np.stack(tip, 1))
        columns["action"].append(actions.swapaxes(0, 1))
        columns["reward"].append(np.stack(reward, 1))
        columns["target"].append(episodes.target_m)
        columns["target_pixels"].append(pixels.reshape(EPISODES, FRAMES))
        columns["target_pixels_free"].append(
            target_pixels_unhidden(scene, view, places[:, 0], episodes.target_m)
        )
    attributes = {"scene": SCENE, "theta_deg": THETA_DEG, "phi_deg": PHI_DEG}
    write_store(path, zarrs.FRAMES, {name: np.stack(c) for name, c in columns.items()}, attributes)


@dataclass(frozen=True)
class Workplace:
    """A folder with its own params.yaml, scratch store and artefacts."""

    root: Path
    cores: int = 1

    def write_params(self, vae_epochs: int = 2, mdnrnn_epochs: int = 2) -> None:
        tree = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
        tree["budget"] = "short"
        vae = {"epochs": vae_epochs, "batch": 16, "frame_stride": 2}
        tree["budgets"] = {"short": {"vae": vae, "mdnrnn": {"epochs": mdnrnn_epochs, "batch": 4}}}
        (self.root / "params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")

    def start(self, stage: str, *flags: str | Path, before: str = "") -> subprocess.Popen[str]:
        """Starts a stage; ``before`` is Python that runs first."""
        imports = f"from pipeline.storage.stage import entry\nfrom pipeline.{stage} import main"
        code = f"{before}\n{imports}\nentry(main)"
        environment = {k: v for k, v in os.environ.items() if not k.startswith("BELVEDERE_")}
        environment |= {"PYTHONPATH": str(ROOT), "BELVEDERE_CORES": str(self.cores)}
        command = [sys.executable, "-c", code, *(str(flag) for flag in flags)]
        return subprocess.Popen(
            command, cwd=self.root, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )

    def run(self, stage: str, *flags: str | Path, before: str = "", status: int = 0) -> str:
        """Runs a stage to its end; what it said."""
        process = self.start(stage, *flags, before=before)
        out, err = process.communicate(timeout=300)
        assert process.returncode == status, out + err
        return out + err

    def vae(self, frames: Path) -> tuple[str | Path, ...]:
        """The flags of stage vae."""
        places = ("--out", "vae", "--metrics", "vae.json", "--picture", "reconstructions.png")
        return ("--frames", frames, *places)

    def bytes_of(self, *names: str) -> dict[str, bytes]:
        """All files below the named places."""
        files = [f for name in names for f in ([self.root / name, *sorted((self.root / name).rglob("*"))])]
        return {str(f.relative_to(self.root)): f.read_bytes() for f in files if f.is_file()}
