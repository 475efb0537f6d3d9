"""The split into training and held-out episodes."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.split import split_episodes


@pytest.mark.parametrize("episodes", [2, 3, 10, 150])
@pytest.mark.parametrize("share", [0.01, 0.1, 0.5, 0.99])
def test_the_parts_are_disjoint_whole_and_never_empty(episodes: int, share: float) -> None:
    training, heldout = split_episodes(episodes, share)
    assert len(training) and len(heldout)
    np.testing.assert_array_equal(np.sort(np.concatenate([training, heldout])), np.arange(episodes))


def test_the_share_is_kept_where_it_can_be() -> None:
    assert len(split_episodes(150, 0.1)[1]) == 15


@pytest.mark.parametrize("episodes", [0, 1])
def test_too_few_episodes_are_told(episodes: int) -> None:
    with pytest.raises(BelvedereError, match=rf"hold {episodes} episode.*rollouts\.episodes in params\.yaml"):
        split_episodes(episodes, 0.1)
