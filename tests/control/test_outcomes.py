from __future__ import annotations

import numpy as np

from pipeline.contract import seeds
from pipeline.control.outcomes import evaluation_episodes, means, outcomes
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.tasks import REACH


def test_a_row_says_whether_and_when_the_tip_came_near() -> None:
    """The first tip comes to 3 cm and then to 1 cm and leaves again; the second stays away."""
    episodes = Episodes.at(start_m=np.array([[0.1, 0, 0], [0, 0, 0.5]]), target_m=np.zeros((2, 3)))
    away = np.array([[0.10, 0.03, 0.01, 0.06], [0.5, 0.5, 0.5, 0.5]])
    first, second = outcomes(3, REACH, episodes, away, -away[:, 1:]).to_dicts()
    assert (first["repeat"], first["episode"], second["episode"]) == (3, 0, 1)
    assert np.isclose(first["return"], -0.10)
    assert np.isclose(first["final_distance_m"], 0.06)
    assert (first["within_5cm"], first["frames_to_5cm"]) == (True, 1)
    assert (first["within_2cm"], first["frames_to_2cm"]) == (True, 2)
    assert (second["within_5cm"], second["frames_to_5cm"], second["frames_to_2cm"]) == (False, None, None)
    assert (second["start_z_m"], second["target_x_m"]) == (0.5, 0.0)


def test_means_over_repeats_and_of_each() -> None:
    episodes = Episodes.at(np.zeros((2, 3)), np.zeros((2, 3)))
    rows = [outcomes(r, REACH, episodes, np.zeros((2, 2)), np.full((2, 1), -1.0 - r)) for r in range(2)]
    found = means(rows[0].vstack(rows[1]), lambda part: {"return": part["return"].mean()})
    assert found == {
        "return_mean": -1.5,
        "repeats": [{"repeat": 0, "return": -1.0}, {"repeat": 1, "return": -2.0}],
    }


def test_evaluation_episodes_are_kept_apart(scene: Scene) -> None:
    held_out = evaluation_episodes(scene, 8, seed=1, repeat=0)
    np.testing.assert_array_equal(held_out.start_m, evaluation_episodes(scene, 8, 1, 0).start_m)
    assert not np.isin(held_out.start_m[:, 1], evaluation_episodes(scene, 8, 1, 1).start_m[:, 1]).any()
    for stream in (seeds.Stream.TRAINING_EPISODES, seeds.Stream.BLIND, seeds.Stream.ROLLOUTS):
        trained = draw_episodes(scene, 8, seeds.generator(1, 0, stream))
        assert not np.isin(held_out.start_m[:, 1], trained.start_m[:, 1]).any()
