"""Trains the MDN-RNN of one viewpoint: one network per repeat, on that repeat's latents."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract import params, seeds
from pipeline.contract.seeds import Stream
from pipeline.contract.source import code_digest
from pipeline.contract.split import split_episodes
from pipeline.learning.device import Compute, set_up_torch
from pipeline.learning.side_by_side import side_by_side
from pipeline.storage import zarrs
from pipeline.storage.artefacts import write_json
from pipeline.storage.repeats import finished, publish
from pipeline.storage.scratch import digest_files
from pipeline.storage.stage import entry
from pipeline.worldmodel.mdnrnn import save_mdnrnn
from pipeline.worldmodel.mdnrnn_training import Sequences, fit, sequences
from pipeline.worldmodel.params import MdnRnnParams, MdnRnnSizes

READ = ("mean", "log_variance", "action")  # not the reward: the network does not see it


def main(*, latents: Path, out: Path, metrics: Path) -> None:
    """Writes ``out/repeat_{r}.pt`` and the metrics."""
    store = zarrs.Store(latents, zarrs.LATENTS, "latents")
    place = set_up_torch()
    results = side_by_side(lambda repeat: train_repeat(store, repeat, place), store.repeats)
    publish(out, metrics, store.attributes, results, "mdnrnn")


def train_repeat(store: zarrs.Store, repeat: int, place: Compute) -> Path:
    """The scratch folder of a repeat's finished ``weights.pt`` and ``metrics.json``."""
    scene = str(store.attributes["scene"])
    method = params.section(MdnRnnParams, "mdnrnn")
    sizes = params.budget_section(MdnRnnSizes, "mdnrnn", scene)
    share, seed = params.heldout_share(), params.seed()

    def make(results: Path, running: Path) -> None:
        arrays = {name: store.repeat(name, repeat) for name in READ}
        training, heldout = split_episodes(len(arrays["mean"]), share)

        def chosen(episodes: np.ndarray) -> Sequences:
            columns = {name: arrays[name][episodes] for name in READ}
            return sequences(columns, place.device)

        draws, what = seeds.integer(seed, repeat, Stream.MDNRNN), f"mdnrnn, repeat {repeat}"
        network, numbers = fit(chosen(training), chosen(heldout), method, sizes, place, draws, running, what)
        save_mdnrnn(results / "weights.pt", network)
        write_json(results / "metrics.json", numbers)

    cache_key: dict[str, Any] = {"inputs": digest_files([store.place(repeat)]), "code": code_digest("mdnrnn")}
    cache_key |= {"method": method.model_dump(), "sizes": sizes.model_dump(), "machine": place.facts()}
    return finished("mdnrnn", repeat, make, seed=seed, heldout_share=share, **cache_key)


if __name__ == "__main__":
    entry(main)
