"""A view's judge without one of its parts: its controllers searched for, and tried in the simulator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from pipeline.ablations.dream import Dream, DreamLoops, learn_reward
from pipeline.ablations.params import AblationParams
from pipeline.contract import seeds
from pipeline.contract.machine import cores
from pipeline.contract.seeds import Stream
from pipeline.contract.split import split_episodes
from pipeline.contract.viewpoints import Viewpoint
from pipeline.control.first import Experience
from pipeline.control.jobs import Job, Networks
from pipeline.control.loops import Loops, closed_loops
from pipeline.control.outcomes import evaluation_episodes
from pipeline.control.params import ControllerParams, SearchSizes
from pipeline.control.search import Repeat, search_controllers
from pipeline.learning.device import Compute
from pipeline.learning.training import seeded
from pipeline.sim.scene import Scene
from pipeline.storage.zarrs import Store
from pipeline.worldmodel.mdnrnn import MdnRnn
from pipeline.worldmodel.mdnrnn_training import initialised
from pipeline.worldmodel.params import MdnRnnParams

VARIANTS = ("z alone", "h untrained", "dream")
READ = ("mean", "log_variance", "action", "reward")


@dataclass(frozen=True)
class Setting:
    """What all variants of a view share.

    Attributes:
        scene: compiled.
        view: of the camera.
        place: where the networks compute.
        method: of the search.
        sizes: of the search in the simulator.
        declared: section ``ablation``.
        mdnrnn: how the MDN-RNN was trained.
        episodes: of each repeat's evaluation.
        heldout_share: of the random episodes, which the search does not see.
        seed: the root of every draw.
    """

    scene: Scene
    view: Viewpoint
    place: Compute
    method: ControllerParams
    sizes: SearchSizes
    declared: AblationParams
    mdnrnn: MdnRnnParams
    episodes: int
    heldout_share: float
    seed: int


def returns_without(
    setting: Setting,
    variant: str,
    latents: Store,
    models: Mapping[int, tuple[Path, Path]],
    running: Mapping[int, Path],
) -> dict[int, float]:
    """Of each repeat the mean return, m, of its controller on the repeat's evaluation episodes.

    Args:
        setting: the view's.
        variant: one of :data:`VARIANTS`.
        latents: of the view's random episodes.
        models: of each repeat the files of its VAE and MDN-RNN.
        running: of each repeat the folder of its search's checkpoint.
    """
    trained = {r: Networks.load(vae, mdnrnn, setting.place) for r, (vae, mdnrnn) in models.items()}
    networks = {r: Networks(own.encoder, _memory(setting, variant, r, own.rnn)) for r, own in trained.items()}
    seen = {r: _experience(setting, latents, r) for r in models}
    repeats = [Repeat(r, _without_variance(seen[r]), networks[r].rnn, running[r]) for r in models]
    simulated = closed_loops(
        setting.scene, setting.view, list(networks.values()), setting.place.device, cores()
    )
    loops: Loops = simulated
    if variant == "dream":
        loops = DreamLoops(setting.scene, [_dream(setting, r, networks[r].rnn, seen[r]) for r in models])
    searches = search_controllers(
        loops, repeats, setting.method, search_sizes(setting, variant), setting.seed
    )
    jobs = []
    for member, (repeat, search) in enumerate(zip(models, searches, strict=True)):
        episodes = evaluation_episodes(setting.scene, setting.episodes, setting.seed, repeat)
        jobs.append(Job.of(member, search.incumbent[None], episodes))
    return {r: float(t.returns.mean()) for r, t in zip(models, simulated.run(jobs), strict=True)}


def search_sizes(setting: Setting, variant: str) -> SearchSizes:
    """Those of the judge; a dream costs little and has its own episodes and generations."""
    dream = setting.declared.dream
    if variant != "dream" or setting.sizes.generations == 1:  # as where the judge cannot see
        return setting.sizes
    return setting.sizes.model_copy(update={"episodes": dream.episodes, "generations": dream.generations})


def _memory(setting: Setting, variant: str, repeat: int, trained: MdnRnn) -> MdnRnn:
    """What h comes from: an LSTM without weights leaves h at zero, so that only z is left."""
    if variant == "dream":
        return trained
    generator = seeded(seeds.integer(setting.seed, repeat, Stream.MDNRNN))
    untrained = initialised(trained.actions, setting.mdnrnn, generator)
    if variant == "z alone":
        for weights in untrained.lstm.parameters():
            torch.nn.init.zeros_(weights)
    return untrained.eval().requires_grad_(False)


def _experience(setting: Setting, latents: Store, repeat: int) -> dict[str, np.ndarray]:
    """The random episodes of a repeat on which its networks were trained."""
    arrays = {name: latents.repeat(name, repeat) for name in READ}
    training, _ = split_episodes(len(arrays["reward"]), setting.heldout_share)
    return {name: array[training] for name, array in arrays.items()}


def _without_variance(seen: Mapping[str, np.ndarray]) -> Experience:
    return Experience.of(**{name: array for name, array in seen.items() if name != "log_variance"})


def _dream(setting: Setting, repeat: int, rnn: MdnRnn, seen: Mapping[str, np.ndarray]) -> Dream:
    declared = setting.declared.dream
    mean, log_variance, reward = (torch.from_numpy(seen[n]) for n in ("mean", "log_variance", "reward"))
    seed = seeds.integer(setting.seed, repeat, Stream.PROBES)
    network = learn_reward(mean, log_variance, reward, declared.reward, seed)
    return Dream(rnn, network, mean[:, 0], declared.temperature)
