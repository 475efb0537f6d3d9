"""A folder in which the stages from controller to evaluation run, on a world model that learned nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
import yaml

from pipeline.contract import params
from pipeline.learning import checkpoints
from pipeline.storage import zarrs
from pipeline.storage.artefacts import write_json
from pipeline.worldmodel.mdnrnn import MdnRnn, save_mdnrnn
from pipeline.worldmodel.vae import Vae
from tests.stores import write_store

ROOT = Path(__file__).resolve().parents[2]
SCENE, ACTIONS = "panda_2dof", 2
VIEW = {"scene": SCENE, "theta": 45.0, "phi": 15.0}
EPISODES, FRAMES = 6, 4
FIRST = 2  # repeats before any comparison


def write_params(folder: Path, generations: int = 2, seed: int = 1) -> None:
    """The repository's params.yaml with short episodes and few of them."""
    tree = yaml.safe_load(
        (Path(__file__).resolve().parents[2] / params.PARAMS_FILE).read_text(encoding="utf-8")
    )
    tree["scenes"][SCENE]["frames"] = FRAMES
    search = {"population": 4, "episodes": 2, "generations": generations}
    tree["controller"] = {
        "first": "rewards",
        "ridge": 0.001,
        "sigma": 0.2,
        "diagonal": True,
        "hidden_share": 0.2,
    }
    tree["budget"], tree["seed"] = "short", seed
    tree["budgets"]["short"] = {
        "race": {"first": FIRST, "most": 3},
        "controller": search,
        "evaluation": {"episodes": 4},
    }
    (folder / "params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")


def write_world_model(folder: Path, repeats: int = 1) -> dict[str, Path]:
    """The flags ``vae`` and ``mdnrnn``, and what they name."""
    for repeat in range(repeats):
        torch.manual_seed(repeat)
        checkpoints.save(folder / f"vae/repeat_{repeat}.pt", Vae().state_dict())
        save_mdnrnn(folder / f"mdnrnn/repeat_{repeat}.pt", MdnRnn(ACTIONS, log_sigma_bound=5.0))
    return {"vae": Path("vae"), "mdnrnn": Path("mdnrnn")}


def write_probes(folder: Path, sees: bool = True) -> dict[str, Path]:
    """The flag ``probes``: metrics of a VAE whose latent tells where tip and target are, or not."""
    entries = ("tip_m", "target_m", "tip_to_target_m")
    errors = {f"probe_mlp_{name}": 0.01 if sees else 0.19 for name in entries}
    errors |= {f"guess_{name}": 0.2 for name in entries}
    write_json(folder / "vae.json", {"repeats": [{"repeat": r, **errors} for r in range(FIRST)]})
    return {"probes": Path("vae.json")}


def write_latents(folder: Path, repeats: int = 1) -> dict[str, Path]:
    """The flag ``latents``, and what it names: a repeat's numbers are the same however many there are."""
    rng = [np.random.default_rng(repeat) for repeat in range(repeats)]
    shapes = {"mean": (32,), "log_variance": (32,), "action": (ACTIONS,), "reward": ()}
    arrays = {
        name: np.stack([r.standard_normal((EPISODES, FRAMES, *shape)) for r in rng])
        for name, shape in shapes.items()
    }
    write_store(folder / "latents", zarrs.LATENTS, arrays, {})
    return {"latents": Path("latents")}
