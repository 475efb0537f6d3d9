"""The stages that picture a viewpoint refuse one from which a whole target position is hidden."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pipeline import dqn, frames
from pipeline.contract.errors import BelvedereError

BELOW_THE_DESK = {"scene": "panda_2dof", "theta": 0.0, "phi": -30.0}


FILES = {frames: ("branch", "rollouts", "out", "picture"), dqn: ("out", "curve", "metrics")}


@pytest.mark.parametrize(("stage", "files"), FILES.items())
def test_a_view_that_hides_a_target_is_refused_before_any_work(
    stage: Any, files: tuple[str, ...], tmp_path: Path
) -> None:
    with pytest.raises(BelvedereError, match="desk hides the whole target"):
        stage.main(**BELOW_THE_DESK, **{name: tmp_path / name for name in files})
    assert not list(tmp_path.iterdir())
