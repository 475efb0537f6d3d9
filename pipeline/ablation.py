"""Says what a view's judge reaches without one of its parts: without h, with an untrained h, from a dream."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.ablations.params import AblationParams
from pipeline.ablations.variants import VARIANTS, Setting, returns_without, search_sizes
from pipeline.contract import params
from pipeline.contract.source import code_digest
from pipeline.contract.viewpoints import viewpoint
from pipeline.control.outcomes import provenance
from pipeline.control.params import ControllerParams, EvaluationSizes
from pipeline.control.search import search_sizes as controller_sizes
from pipeline.learning.device import set_up_torch
from pipeline.sim.scene import load_scene
from pipeline.stats.blocks import own_interval
from pipeline.stats.branches import read_branch, unit_of
from pipeline.stats.reading import COMPARED, check_made_alike, mixture_allowed
from pipeline.storage import scratch, zarrs
from pipeline.storage.artefacts import read_json, write_json
from pipeline.storage.repeats import Place, finished_together
from pipeline.storage.stage import entry
from pipeline.worldmodel.params import MdnRnnParams

CONFIDENCE = 0.95
RETURN = "return.json"


def main(
    *,
    scene: str,
    theta: float,
    phi: float,
    probes: Path,
    latents: Path,
    vae: Path,
    mdnrnn: Path,
    evaluation: Path,
    anchors: Path,
    out: Path,
) -> None:
    """Writes the score of each variant and its change from the whole judge's, with intervals over repeats.

    ``probes`` are the VAE's metrics: where the judge cannot see, one generation is searched.
    ``latents``, ``vae`` and ``mdnrnn`` are those of the branch; ``evaluation`` are the whole judge's metrics,
    ``anchors`` the scene's.
    """
    setting, view = _setting(scene, theta, phi, probes), viewpoint(scene, theta, phi)
    unit_m, blind_m = unit_of(anchors, scene), float(_blind(anchors))
    whole, made = read_branch(evaluation, evaluation.parent.name, view)
    if not mixture_allowed():
        here = provenance(setting.place.facts())
        check_made_alike(scene, {evaluation.parent.name: made, "this machine": here}, COMPARED)
    store = zarrs.Store(latents, zarrs.LATENTS, "latents")
    count = min(setting.declared.repeats, store.repeats, len(whole))
    models = {r: (vae / f"repeat_{r}.pt", mdnrnn / f"repeat_{r}.pt") for r in range(count)}
    scores = {"whole": (whole[:count] - blind_m) / unit_m}
    for variant in VARIANTS:
        scores[variant] = (_returns(setting, variant, store, models) - blind_m) / unit_m
    rows = {name: _row(own, scores["whole"]) for name, own in scores.items()}
    head = {"scene": scene, "theta_deg": theta, "phi_deg": phi, "repeats": count}
    head |= {"budget": params.budget(), "seed": params.seed()}
    write_json(out, {**head, "variants": rows, "provenance": provenance(setting.place.facts())})


def _setting(scene: str, theta: float, phi: float, probes: Path) -> Setting:
    return Setting(
        scene=load_scene(scene),
        view=viewpoint(scene, theta, phi),
        place=set_up_torch(),
        method=params.section(ControllerParams, "controller"),
        sizes=controller_sizes(scene, probes, params.first_repeats(scene)),
        declared=params.section(AblationParams, "ablation"),
        mdnrnn=params.section(MdnRnnParams, "mdnrnn"),
        episodes=params.budget_section(EvaluationSizes, "evaluation", scene).episodes,
        heldout_share=params.heldout_share(),
        seed=params.seed(),
    )


def _blind(anchors: Path) -> np.floating[Any]:
    return np.mean([row["blind"] for row in read_json(anchors, "anchors")["repeats"]])


def _returns(
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


def _row(own: np.ndarray, whole: np.ndarray) -> dict[str, Any]:
    """A variant's scores by repeat, their mean, and the change from the whole judge's, repeat by repeat."""
    change, low, high = own_interval(own - whole, CONFIDENCE)
    changes = {"change": change, "low": low, "high": high} if own is not whole else {}
    return {"scores": own.tolist(), "score": float(own.mean()), **changes}


if __name__ == "__main__":
    entry(main)
