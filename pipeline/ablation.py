"""Says what a view's judge reaches without one of its parts: without h, with an untrained h, from a dream."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from pipeline.ablations.made import finished_returns, read_setting
from pipeline.ablations.variants import VARIANTS
from pipeline.contract import params
from pipeline.contract.viewpoints import viewpoint
from pipeline.control.outcomes import provenance
from pipeline.stats.blocks import own_interval
from pipeline.stats.branches import read_branch, unit_of
from pipeline.stats.reading import COMPARED, check_made_alike, mixture_allowed
from pipeline.storage import zarrs
from pipeline.storage.artefacts import read_json, write_json
from pipeline.storage.stage import entry

CONFIDENCE = 0.95


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
    view = viewpoint(scene, theta, phi)
    setting = read_setting(scene, view, probes)
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
        scores[variant] = (finished_returns(setting, variant, store, models) - blind_m) / unit_m
    rows = {name: _row(own, scores["whole"]) for name, own in scores.items()}
    head = {"scene": scene, "theta_deg": theta, "phi_deg": phi, "repeats": count}
    head |= {"budget": params.budget(), "seed": params.seed()}
    write_json(out, {**head, "variants": rows, "provenance": provenance(setting.place.facts())})


def _blind(anchors: Path) -> np.floating[Any]:
    return np.mean([row["blind"] for row in read_json(anchors, "anchors")["repeats"]])


def _row(own: np.ndarray, whole: np.ndarray) -> dict[str, Any]:
    """A variant's scores by repeat, their mean, and the change from the whole judge's, repeat by repeat."""
    change, low, high = own_interval(own - whole, CONFIDENCE)
    changes = {"change": change, "low": low, "high": high} if own is not whole else {}
    return {"scores": own.tolist(), "score": float(own.mean()), **changes}


if __name__ == "__main__":
    entry(main)
