"""Says what a finalist's score loses when its camera is not mounted quite where it was trained."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from pipeline.contract import params
from pipeline.contract.viewpoints import viewpoint
from pipeline.control.jobs import Networks
from pipeline.control.mounting import returns_standing_off
from pipeline.control.outcomes import evaluation_episodes, provenance
from pipeline.control.params import MountingParams
from pipeline.control.policy import load_controller
from pipeline.learning.device import set_up_torch
from pipeline.sim.scene import load_scene, with_camera
from pipeline.stats.blocks import own_interval
from pipeline.stats.branches import unit_of
from pipeline.storage.artefacts import write_json
from pipeline.storage.stage import entry

CONFIDENCE = 0.95


def main(
    *,
    scene: str,
    theta: float,
    phi: float,
    vae: Path,
    mdnrnn: Path,
    controller: Path,
    anchors: Path,
    out: Path,
    distance: float = 0,
    fov: float = 0,
) -> None:
    """Writes the change in score at each offset of ``mounting`` in params.yaml, with its interval.

    ``vae``, ``mdnrnn`` and ``controller`` are folders with a file for each repeat; ``anchors`` are those of
    the scene. ``distance``, m, and ``fov``, degrees, are the camera's; 0: the scene's.
    """
    compiled, view = with_camera(load_scene(scene), distance, fov), viewpoint(scene, theta, phi)
    place = set_up_torch()
    declared, unit_m = params.section(MountingParams, "mounting"), unit_of(anchors, scene)
    repeats = range(min(declared.repeats, len(list(controller.glob("repeat_*.npz")))))
    networks = [Networks.load(vae / f"repeat_{r}.pt", mdnrnn / f"repeat_{r}.pt", place) for r in repeats]
    flat = [load_controller(controller / f"repeat_{r}.npz", compiled.action_size) for r in repeats]
    episodes = [evaluation_episodes(compiled, declared.episodes, params.seed(), r) for r in repeats]
    found = returns_standing_off(compiled, view, networks, flat, episodes, declared, place)
    at_place = found[0][1]
    rows = []
    for off, returns in found[1:]:
        mean, low, high = own_interval((returns - at_place) / unit_m, CONFIDENCE)
        changes = {"change": mean, "low": low, "high": high}
        rows.append({**asdict(off), **changes, "turn_deg": off.turn_deg, "move_m": off.move_m})
    head = {"scene": scene, "theta_deg": theta, "phi_deg": phi, "repeats": len(repeats)}
    write_json(out, {**head, "offsets": rows, "provenance": provenance(place.facts())})


if __name__ == "__main__":
    entry(main)
