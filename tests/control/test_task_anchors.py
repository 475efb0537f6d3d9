"""The anchors of every task: the expert does it, sight is needed, and blindness is no telepathy."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.contract.anchors import anchor_warnings
from pipeline.control.anchors import Policy, expert, nothing, play
from pipeline.control.blind import TargetBlind
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds
from tests.examples import KINDS, example

EPISODES = 96


def blind(scene: Scene, episodes: Episodes) -> Policy:
    return TargetBlind(scene, np.random.default_rng(1)).policy(episodes.start_m)


@pytest.mark.parametrize("kind", KINDS)
def test_the_expert_beats_target_blind_and_that_beats_doing_nothing(kind: str) -> None:
    """By far more than three standard errors, and without a warning; the expert succeeds every time."""
    scene = example(kind)
    worlds, episodes = Worlds(scene, EPISODES, 2), draw_episodes(scene, EPISODES, np.random.default_rng(2))
    policies = {"no_op": nothing, "blind": blind(scene, episodes), "expert": expert(scene)}
    played = {name: play(worlds, episodes, policy) for name, policy in policies.items()}
    returns = {name: each.reward.sum(axis=1) for name, each in played.items()}
    for better, worse in (("expert", "blind"), ("blind", "no_op")):
        gain = returns[better] - returns[worse]
        assert gain.mean() > 5 * gain.std() / np.sqrt(EPISODES) > 0
    assert returns["expert"].mean() - returns["blind"].mean() > 2.5
    done = scene.task.succeeded(played["expert"].error_m, 0.02)
    assert done.any(axis=1).all() and done[:, -1].all()
    means = {name: float(values.mean()) for name, values in returns.items()}
    assert not anchor_warnings(kind, **means, done=float(done.any(axis=1).mean()))


@pytest.mark.parametrize("kind", KINDS)
def test_other_targets_change_nothing_of_what_the_blind_do(kind: str) -> None:
    """With the same starts and pucks; follow's targets differ by their phase."""
    scene = example(kind)
    worlds, episodes = Worlds(scene, 8), draw_episodes(scene, 8, np.random.default_rng(3))
    moved = episodes.drawn if kind == "push" else episodes.drawn[::-1].copy()
    others = Episodes(episodes.start_m, episodes.target_m[::-1].copy(), moved)
    tips = [play(worlds, each, blind(scene, episodes)).tip_m for each in (episodes, others)]
    np.testing.assert_array_equal(*tips)


def test_blind_to_where_on_the_circle_the_target_is_the_middle_is_best() -> None:
    scene = example("follow")
    starts = draw_episodes(scene, 4, np.random.default_rng(4)).start_m
    believed = TargetBlind(scene, np.random.default_rng(1)).targets(starts)
    assert believed.shape == (4, scene.frames + 1, 3)
    assert np.abs(believed - [0.5, 0.0, 0.23]).max() < 0.01


def test_the_blind_come_above_the_middle_container_whatever_height_they_start_at() -> None:
    scene = example("align")
    starts = draw_episodes(scene, 4, np.random.default_rng(4)).start_m
    believed = TargetBlind(scene, np.random.default_rng(1)).targets(starts) + scene.task.offset_m
    np.testing.assert_allclose(
        believed[:, :, 1:], np.broadcast_to([0.0, 0.14], believed[:, :, 1:].shape), atol=1e-3
    )


@pytest.mark.parametrize(
    ("levels", "told"),
    [
        ((-6.0, -1.0, -0.5, 1.0), [r"target-blind policy returns -1.00 m, near the expert's -0.50 m"]),
        ((-6.0, -4.0, -0.5, 0.8), ["comes within 2 cm in only 80% of the episodes"]),
        ((-6.0, -0.4, -0.5, 0.0), ["near the expert's", "in only 0%"]),
        ((-6.0, -4.0, -0.5, 1.0), []),
    ],
)
def test_what_makes_a_ranking_say_little_is_told(levels: tuple[float, ...], told: list[str]) -> None:
    found = anchor_warnings("mine", *levels)
    assert len(found) == len(told)
    for sentence, words in zip(found, told, strict=True):
        assert words in sentence and "scene mine" in sentence and "\n" not in sentence
