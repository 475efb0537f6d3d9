"""A search on made-up trainings: candidates whose true scores are known, and the stage that looks at them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pipeline import search
from pipeline.placement.sphere import lattice
from pipeline.storage.candidates import Candidate, Placed, RuledOut, write_placed
from tests.placement.declared import HALF
from tests.stages.test_ranking import PROBES, PROVENANCE

SCENE = "reach"
PLACED, ANCHORS = Path("search/candidates.yaml"), Path("anchors.json")
OUT, TABLE, MAP = (Path("search/found") / f"{SCENE}{end}" for end in (".json", ".csv", "_map.csv"))
BLIND, UNIT_M = -6.0, 5.0
LOST = ("probe_mlp_tip_m", "probe_mlp_tip_to_target_m")  # by those from which the judge cannot see

Score = Callable[[float, float], float]


def ridge(theta_deg: float, phi_deg: float) -> float:
    """Best at (30°, 35°), worse by .25 at 45° from there."""
    return 0.9 - 0.25 * ((theta_deg - 30) ** 2 + (phi_deg - 35) ** 2) / 45**2


class Study:
    """A working directory with a search, whose trainings come from a known map and a seed."""

    def __init__(self, score: Score = ridge, sd: float = 0.04, **procedure: Any) -> None:
        self.score, self.sd = score, sd
        self.views = {
            f"{SCENE}-c{n:02}": Candidate(scene=SCENE, theta=theta, phi=phi, distance_m=1.4, fov_deg=40)
            for n, (theta, phi) in enumerate(lattice(HALF, HALF.candidates), start=1)
        }
        self.blind_to: set[str] = set()
        self.repeats = dict.fromkeys(self.views, 0)
        self.write_params(**({"finalists": 6, "most_trainings": None} | procedure))
        self.place(self.views)
        rows = [{"repeat": r, "no_op": -7.0, "blind": BLIND, "expert": BLIND + UNIT_M} for r in range(3)]
        write_json(ANCHORS, {"scene": SCENE, "repeats": rows, "provenance": PROVENANCE})

    def write_params(self, **procedure: Any) -> None:
        tree = {
            "ranking": {"confidence": 0.95, "tolerance": 0.05, "equivalence_margin": 0.1},
            "seed": 1,
            "sight_share": 0.5,
            "budget": "few",
            "budgets": {"few": {"race": {"first": 3, "most": 20}}},
            "searches": {SCENE: {"procedure": procedure}},
        }
        Path("params.yaml").write_text(yaml.safe_dump(tree, sort_keys=False))

    def place(self, views: Mapping[str, Candidate]) -> None:
        """Writes the file of candidates."""
        out = (RuledOut(theta=0, phi=-5, distance_m=1.4, fov_deg=40, why="the table hides a target"),)
        write_placed(Placed(candidates=dict(views), ruled_out={SCENE: out}), PLACED)

    def train(self, needed: Mapping[str, int]) -> None:
        """Gives candidates repeats: what all share in a repeat, and scatter of their own."""
        for key, count in needed.items():
            self.repeats[key] = max(self.repeats[key], count)
            view, own = self.views[key], np.random.default_rng([7, int(key[-2:])])
            scatter = own.normal(0, self.sd, 40)
            shared = np.random.default_rng(8).normal(0, 0.05, 40)
            score = self.score(view.theta, view.phi) + scatter + shared
            self._write(key, view, BLIND + UNIT_M * score[: self.repeats[key]])

    def _write(self, key: str, view: Candidate, returns: np.ndarray) -> None:
        place = {"scene": SCENE, "theta_deg": view.theta, "phi_deg": view.phi}
        rows = [{"repeat": r, "return": float(value)} for r, value in enumerate(returns)]
        write_json(self.folder / key / "evaluation.json", place | {"repeats": rows, "provenance": PROVENANCE})
        probes = PROBES | (dict.fromkeys(LOST, 0.19) if key in self.blind_to else {})
        write_json(self.folder / key / "vae.json", place | {"repeats": [{"repeat": 0, **probes}]})

    @property
    def folder(self) -> Path:
        return Path("candidates")

    def look(self) -> dict[str, Any]:
        """Runs the stage and returns what it says."""
        self.folder.mkdir(exist_ok=True)
        search.main(
            scene=SCENE, placed=PLACED, candidates=self.folder, anchors=ANCHORS, out=OUT, table=TABLE, map=MAP
        )
        return json.loads(OUT.read_text(encoding="utf-8"))

    def run(self) -> list[dict[str, Any]]:
        """Trains what the stage asks for until it asks for nothing; returns what it said each time."""
        said = [self.look()]
        while said[-1]["needed"]:
            self.train(said[-1]["needed"])
            said.append(self.look())
        return said


def write_json(path: Path, content: object) -> None:
    """Writes a table as stages do."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content), encoding="utf-8")
