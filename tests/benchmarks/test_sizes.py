"""What the table of sizes reports, and that its training is the stages'."""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from benchmarks.sizes import KEY, PARTS, changed, measured, scored
from benchmarks.training import command
from pipeline.contract.errors import BelvedereError
from pipeline.storage.stage import parser


def test_a_change_is_put_in_its_place_and_nowhere_else() -> None:
    tree = {"vae": {"beta": 1.0, "schedule": {"learning_rate": 0.001}}, "seed": 1}
    wanted = {"vae": {"beta": 1.0, "schedule": {"learning_rate": 0.003}}, "seed": [2, 3]}
    assert changed(tree, ["vae.schedule.learning_rate=0.003", "seed=[2, 3]"]) == wanted


@pytest.mark.parametrize("change", ["vae.beta", "vae.gamma=1", "vae.beta.more=1", "beta=1"])
def test_a_change_without_a_place_is_told_in_one_sentence(change: str) -> None:
    with pytest.raises(BelvedereError, match=r"params\.yaml has no value there"):
        changed({"vae": {"beta": 1.0}}, [change])


def test_anchors_have_the_scores_nought_and_one() -> None:
    found = scored([-6.0, -0.5, -3.25], {"blind_mean": -6.0, "expert_mean": -0.5})
    np.testing.assert_allclose(found, [0.0, 1.0, 0.5])


@pytest.mark.parametrize("stage", [*PARTS, "anchors"])
def test_each_stage_takes_the_flags_that_it_is_given(stage: str) -> None:
    _, name, *flags = command(stage, KEY, {"scene": "panda_1dof", "theta": 60, "phi": 35})
    given = parser(import_module(name).main).parse_args(flags)
    assert given.scene == "panda_1dof" if "scene" in given else given.out


@pytest.mark.slow
def test_a_tiny_training_gives_a_whole_row() -> None:
    before = Path.cwd(), dict(os.environ)
    view = {"scene": "panda_1dof", "theta": 60, "phi": 35}
    found = measured(view, 2, ["budget=tiny", "budgets.tiny.vae.epochs=1"])
    assert (Path.cwd(), dict(os.environ)) == before
    assert min(found[part] for part in PARTS) > 0 and found["repeats"] == 2
    assert found["changes"] == "budget=tiny tiny.vae.epochs=1"
    assert 0 < found["mlp_tip_to_target cm"] < 100 and found["sd"] > 0
