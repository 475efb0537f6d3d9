"""Measures what geometry alone says of one viewpoint: projected motion, visibility, misalignment."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.baselines.motion import image_jacobian, singular_values
from pipeline.baselines.visibility import visibility
from pipeline.contract.viewpoints import viewpoint
from pipeline.rendering.visibility import PICTURE_SIZE
from pipeline.sim.scene import load_scene
from pipeline.storage import zarrs
from pipeline.storage.artefacts import write_json
from pipeline.storage.positions import target_by_frame
from pipeline.storage.stage import entry

_LEAST_PX_PER_M = 1e-9  # a motion along the line of sight projects to nothing, whose log is no number
_STATES = 512  # of the first repeat's random episodes, evenly picked


def main(*, scene: str, theta: float, phi: float, rollouts: Path, out: Path) -> None:
    """Writes the viewpoint's numbers: means over states of the scene's random episodes."""
    compiled, view = load_scene(scene), viewpoint(scene, theta, phi)
    store = zarrs.Store(rollouts.with_suffix(""), zarrs.ROLLOUTS, f"rollouts@{scene}")
    qpos, tip = store.repeat("qpos", 0), store.repeat("tip", 0)
    target = target_by_frame(store, 0)
    picked = np.unique(np.linspace(0, tip.shape[0] * tip.shape[1] - 1, _STATES).astype(int))
    qpos, tip, target = (a.reshape(-1, a.shape[-1])[picked] for a in (qpos, tip, target))
    values = singular_values(image_jacobian(compiled, view, tip.astype(np.float64), PICTURE_SIZE))
    seen = {name: visibility(compiled, view, qpos, at) for name, at in (("tip", tip), ("target", target))}
    numbers: dict[str, object] = {
        "scene": scene,
        "theta_deg": theta,
        "phi_deg": phi,
        "motion_smallest_px_per_m": float(values[:, -1].mean()),
        "motion_log_det": float(np.log(np.maximum(values, _LEAST_PX_PER_M)).sum(axis=1).mean()),
        "pan_misalignment_deg": abs((theta + 180) % 360 - 180),
    }
    for name, found in seen.items():
        numbers |= {f"{name}_seen_share": found.seen_share, f"{name}_in_frame_share": found.in_frame_share}
        numbers[f"{name}_pixels"] = found.pixels
    write_json(out, numbers)


if __name__ == "__main__":
    entry(main)
