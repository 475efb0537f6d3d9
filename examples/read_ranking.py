"""Reads a scene's ranking: `./run python examples/read_ranking.py panda_2dof`."""

import json
import sys
from pathlib import Path

ranking = json.loads(Path(f"reports/rankings/{sys.argv[1]}.json").read_text(encoding="utf-8"))
print(ranking["answer"]["sentence"])
for key, view in ranking["viewpoints"].items():
    score = "no score" if view["score_mean"] is None else f"score {view['score_mean']:.2f}"
    angles = f"θ {view['theta_deg']:g}°, φ {view['phi_deg']:g}°"
    print(f"{key}: {angles}, {score}, {view['repeats']} repeats, {view['state']}")
