"""operator: the scripted operator's trials from one viewpoint, of which it sees what the view resolves."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.contract import params
from pipeline.contract.machine import cores
from pipeline.contract.viewpoints import viewpoint
from pipeline.scripted.batch import run_trials
from pipeline.scripted.params import OperatorParams
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.storage.artefacts import write_json
from pipeline.storage.stage import entry

_EPISODES, _LOOKS = 90, 91  # purposes of draws, beside those of pipeline.contract.seeds


def main(*, scene: str, theta: float, phi: float, out: Path) -> None:
    """Writes what the trials came to; starts, targets and the draws behind looks are those of every view."""
    compiled, view = load_scene(scene), viewpoint(scene, theta, phi)
    asked = params.section(OperatorParams, "operator")
    count = asked.trials * len(compiled.params.target.candidates_m)
    episodes = draw_episodes(compiled, count, _generator(_EPISODES))
    found = run_trials(compiled, view, asked, episodes, _generator(_LOOKS), cores())
    write_json(
        out,
        {
            "scene": scene,
            "theta_deg": theta,
            "phi_deg": phi,
            "trials": count,
            "grasped_share": float(found.grasped.mean()),
            "time_s_mean": float(found.time_s.mean()),
            "time_s_median": float(np.median(found.time_s)),
            "distance_m_mean": float(found.distance_m.mean()),
            "distance_m_median": float(np.median(found.distance_m)),
            "look_m": dict(zip(compiled.params.axes, map(float, found.look_m), strict=True)),
        },
    )


def _generator(purpose: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(entropy=params.seed(), spawn_key=(0, purpose)))


if __name__ == "__main__":
    entry(main)
