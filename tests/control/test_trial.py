"""What the metrics say of a table of outcomes."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.control.outcomes import means, outcomes
from pipeline.control.trial import numbers
from pipeline.sim.draws import Episodes
from pipeline.sim.tasks import REACH


def test_frames_are_of_the_episodes_that_arrived_and_their_share_stands_beside() -> None:
    """Of four episodes two arrive, after 1 and 3 frames; of the other repeat's two none does."""
    away = np.array([[0.2, 0.04, 0.04, 0.2], [0.2, 0.2, 0.2, 0.01], [0.2] * 4, [0.3] * 4])
    tables = []
    for repeat, distance in enumerate((away, away[2:])):
        episodes = Episodes.at(np.zeros((len(distance), 3)), np.zeros((len(distance), 3)))
        tables.append(outcomes(repeat, REACH, episodes, distance, -distance[:, 1:]))
    found = means(tables[0].vstack(tables[1]), numbers)
    assert found["frames_to_5cm_where_reached_mean"] == pytest.approx((1 + 3) / 2)
    assert found["within_5cm_share_mean"] == pytest.approx(2 / 6)
    first, second = found["repeats"]
    assert (first["frames_to_5cm_where_reached"], first["within_5cm_share"]) == (2.0, 0.5)
    assert (second["frames_to_5cm_where_reached"], second["within_5cm_share"]) == (None, 0.0)
    assert not [name for name in found if name.startswith("frames_to") and "where_reached" not in name]
