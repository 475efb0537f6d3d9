"""What variants of a view's judge return, made once per inputs, parameters, code and machine kind."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.ablations.params import AblationParams
from pipeline.ablations.variants import Setting, returns_without, search_sizes
from pipeline.contract import params
from pipeline.contract.source import code_digest
from pipeline.contract.viewpoints import Viewpoint
from pipeline.control.params import ControllerParams, EvaluationSizes
from pipeline.control.search import search_sizes as controller_sizes
from pipeline.learning.device import set_up_torch
from pipeline.sim.scene import load_scene
from pipeline.storage import scratch, zarrs
from pipeline.storage.artefacts import read_json, write_json
from pipeline.storage.repeats import Place, finished_together
from pipeline.worldmodel.params import MdnRnnParams

RETURN = "return.json"


def read_setting(scene: str, view: Viewpoint, probes: Path) -> Setting:
    """What params.yaml says of a view's judge; ``probes`` are the metrics of its VAE."""
    return Setting(
        scene=load_scene(scene),
        view=view,
        place=set_up_torch(),
        method=params.section(ControllerParams, "controller"),
        sizes=controller_sizes(scene, probes, params.first_repeats(scene)),
        declared=params.section(AblationParams, "ablation"),
        mdnrnn=params.section(MdnRnnParams, "mdnrnn"),
        episodes=params.budget_section(EvaluationSizes, "evaluation", scene).episodes,
        heldout_share=params.heldout_share(),
        seed=params.seed(),
    )


def finished_returns(
    setting: Setting, variant: str, store: zarrs.Store, models: Mapping[int, tuple[Path, Path]]
) -> np.ndarray:
    """(repeat,) mean returns, m, from the scratch store or made now."""

    def make(places: Mapping[int, Place]) -> None:
        running = {r: place.running for r, place in places.items()}
        found = returns_without(setting, variant, store, {r: models[r] for r in places}, running)
        for repeat, place in places.items():
            write_json(place.results / RETURN, {"return": found[repeat]})

    common: dict[str, Any] = {"code": code_digest("ablation"), "machine": setting.place.facts()}
    common |= {"variant": variant, "seed": setting.seed, "heldout_share": setting.heldout_share}
    common |= {"method": setting.method.model_dump(), "sizes": search_sizes(setting, variant).model_dump()}
    common |= {"dream": setting.declared.dream.model_dump() if variant == "dream" else None}
    common |= {"mdnrnn": setting.mdnrnn.model_dump(), "episodes": setting.episodes}
    common |= {"scene": setting.scene.cache_key, "view": setting.view.model_dump()}
    keys = {
        r: {**common, "inputs": scratch.digest_files([store.place(r), *own])} for r, own in models.items()
    }
    folders = finished_together(f"ablation_{variant.replace(' ', '_')}", keys, make)
    return np.array([float(read_json(folder / RETURN, "ablation")["return"]) for folder in folders])
