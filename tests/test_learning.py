"""A real training of the default budget: it must learn. Its results are in no cache, so it takes minutes."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import yaml
from scipy import stats

from tests.support import Clone


@pytest.mark.slow
def test_from_a_good_view_the_default_budget_leaves_blind_behind(clone: Clone) -> None:
    clone.lend_environment()
    clone.run("./run", "dvc", "repro", "evaluation@panda_2dof-a", "anchors@panda_2dof", timeout_s=5400)
    reports = clone.root / "reports"
    returned = json.loads((reports / "branches/panda_2dof/panda_2dof-a/evaluation.json").read_text())
    anchors = json.loads((reports / "anchors/panda_2dof.json").read_text())
    no_op, blind, expert = (anchors[f"{name}_mean"] for name in ("no_op", "blind", "expert"))
    assert expert - blind >= 0.5 * (expert - no_op)
    params = yaml.safe_load((clone.root / "params.yaml").read_text(encoding="utf-8"))
    sizes = params["budgets"][params["budget"]]
    assert len(returned["repeats"]) >= sizes["race"]["first"]
    assert len(anchors["repeats"]) == sizes["race"]["first"]
    assert (returned["return_mean"] - blind) / (expert - blind) >= 0.5


@pytest.mark.slow
def test_deep_q_networks_leave_blind_behind(clone: Clone) -> None:
    """The learner of section III is known to work: its lower 95 % bound over three seeds is above blind."""
    clone.lend_environment()
    path = clone.root / "params.yaml"
    text, scenes = re.subn(r"scenes: \[fetch_reach\]", "scenes: [panda_2dof]", path.read_text())
    text, repeats = re.subn(r"dqn: \{repeats: 0,", "dqn: {repeats: 3,", text)
    assert scenes == repeats == 1
    path.write_text(text)
    clone.run("dvc", "repro", "anchors@panda_2dof", timeout_s=1800)
    anchors = json.loads((clone.root / "reports/anchors/panda_2dof.json").read_text())
    view = ("--scene", "panda_2dof", "--theta", "0", "--phi", "0")
    outs = ("--out", "e.parquet", "--curve", "c.csv", "--metrics", "dqn.json")
    clone.run("python", "-m", "pipeline.dqn", *view, *outs, timeout_s=7200)
    returned = json.loads((clone.root / "dqn.json").read_text())["repeats"]
    blind = {row["repeat"]: row["blind"] for row in anchors["repeats"]}
    gains = np.array([row["return"] - blind[row["repeat"]] for row in returned])
    assert len(gains) == 3
    assert stats.ttest_1samp(gains, 0).confidence_interval(0.95).low > 0
