"""The stage operator: from a view along which the task lies it takes longer and ends farther off."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from pipeline import operator
from pipeline.contract.errors import BelvedereError
from tests.support import ROOT


@pytest.fixture(autouse=True)
def declared(workplace: Path) -> None:
    """The repository's parameters with fewer trials."""
    tree = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
    tree["operator"] |= {"trials": 4, "limit_s": 12}
    (workplace / "params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")


def measured(theta: float, phi: float, scene: str = "panda_2dof") -> dict:
    operator.main(scene=scene, theta=theta, phi=phi, out=Path("operator.json"))
    return json.loads(Path("operator.json").read_text(encoding="utf-8"))


def test_front_and_side() -> None:
    front, side = measured(0, 0), measured(90, 0)
    assert front["trials"] == side["trials"] == 16 and front["grasped_share"] == 1
    assert front["time_s_mean"] < side["time_s_mean"]
    assert front["distance_m_mean"] < side["distance_m_mean"]
    assert side["look_m"]["y"] > 8 * front["look_m"]["y"]  # y lies along the line of sight
    assert (
        side["look_m"]["z"] < 2 * front["look_m"]["z"]
    )  # more, as a place above the middle moves with depth
    assert front["distance_m_mean"] < 0.006 and front["time_s_mean"] < 6
    assert measured(0, 0) == front  # the same bytes for the same inputs


def test_a_trial_that_does_not_end_counts_with_the_limit(workplace: Path) -> None:
    tree = yaml.safe_load(Path("params.yaml").read_text(encoding="utf-8"))
    tree["operator"] |= {"limit_s": 0.5}
    Path("params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")
    found = measured(90, 0)
    assert found["grasped_share"] == 0 and found["time_s_mean"] == 0.5 and found["distance_m_mean"] > 0


def test_bad_parameters_are_told_before_anything_is_written(workplace: Path) -> None:
    tree = yaml.safe_load(Path("params.yaml").read_text(encoding="utf-8"))
    tree["operator"]["gain_per_s"] = -1
    Path("params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")
    with pytest.raises(BelvedereError, match=r"operator\.gain_per_s"):
        measured(0, 0)
    assert not Path("operator.json").exists()
