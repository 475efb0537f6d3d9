"""A real training of the default budget: it must learn. Its results are in no cache, so it takes minutes."""

from __future__ import annotations

import json

import pytest

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
    assert len(returned["repeats"]) == len(anchors["repeats"]) == 3
    assert (returned["return_mean"] - blind) / (expert - blind) >= 0.5
