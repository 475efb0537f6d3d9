"""Order, verdicts and sentences of tables whose answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.stats.branches import Branch, Results
from pipeline.stats.ranks import Ranked, rank
from pipeline.stats.verdict import Verdict, scene_verdict

NOISE = np.array([[0.1, -0.1, 0.0], [-0.1, 0.0, 0.1], [0.0, 0.1, -0.1]])


def results(returns: np.ndarray, blind: float = -10.0, expert: float = 0.0) -> Results:
    """Views a, b, c, … at pans 0°, 10°, 20°, …"""
    views, repeats = returns.shape
    keys = [f"scene-{letter}" for letter in "abcdef"[:views]]
    level = np.ones(repeats)
    return Results(
        branches={key: Branch(scene="scene", theta=10.0 * i, phi=5.0) for i, key in enumerate(keys)},
        duplicates={key: [] for key in keys},
        returns=returns,
        anchors={"no_op": -12 * level, "blind": blind * level, "expert": expert * level},
        made_with={key: {} for key in keys},
    )


def judged(returns: np.ndarray, blind: float = -10.0) -> tuple[list[Ranked], Verdict]:
    table, _ = rank(results(returns, blind), 0.95)
    return table, scene_verdict("scene", table, 0.95, None)


def test_a_best_view_is_separated_from_all_others() -> None:
    table, verdict = judged(np.array([[-5.0], [-2.0], [-5.2]]) + NOISE)
    assert [row.key for row in table] == ["scene-b", "scene-a", "scene-c"]
    assert [row.rank for row in table] == [1, 2, 3]
    assert [row.verdict for row in table] == ["best", "worse", "worse"]
    assert (verdict.kind, verdict.keys) == ("best", ["scene-b"])
    second = table[1]
    assert second.difference_to_best == pytest.approx(-3.0)
    low, high = -(second.difference_high or 0), -(second.difference_low or 0)
    assert 0 < low < 3 < high
    assert verdict.sentence == (
        "Put the camera at (θ, φ) = (10°, 5°): scene-b returns 3 m more than the next best view, scene-a "
        f"(95 % interval {low:.3g} to {high:.3g})."
    )


def test_views_close_to_each_other_are_not_separated() -> None:
    table, verdict = judged(np.array([[-2.05], [-2.0], [-5.0]]) + NOISE)
    assert [row.verdict for row in table] == ["not separated", "not separated", "worse"]
    assert verdict == Verdict("not separated", ["scene-b", "scene-a"], "Not separated: scene-b, scene-a.")


def test_a_judge_that_learned_nothing_is_not_above_blind() -> None:
    table, verdict = judged(np.array([[-5.0], [-2.0], [-5.2]]) + NOISE, blind=-5.1)
    assert [row.verdict for row in table] == ["best", "not above blind", "not above blind"]
    assert verdict.kind == "best"


def test_no_view_above_blind() -> None:
    table, verdict = judged(np.array([[-5.0], [-2.0], [-5.2]]) + NOISE, blind=-1.9)
    assert {row.verdict for row in table} == {"not above blind"}
    assert (verdict.kind, len(verdict.keys)) == ("not above blind", 3)
    assert verdict.sentence.startswith("No view is above blind: scene-b, scene-a, scene-c;")


def test_one_repeat_tells_no_error() -> None:
    table, verdict = judged(np.array([[-5.0], [-2.0]]))
    assert {row.verdict for row in table} == {"not separated"}
    assert all(row.return_low is row.score_high is row.difference_low is None for row in table)
    assert table[1].difference_to_best == pytest.approx(-3.0)
    assert verdict.kind == "not separated"
    assert verdict.sentence == "Not separated: scene-b, scene-a; one repeat tells no error."


def test_an_only_view_is_no_best_view() -> None:
    table, verdict = judged(np.array([[-2.0, -2.1, -1.9]]))
    assert table[0].verdict == verdict.kind == "not separated"
    assert table[0].difference_to_best is None
    assert verdict.sentence == (
        "Not separated: scene-a is the only view of scene, and there is nothing to compare it with."
    )
    assert judged(np.array([[-2.0]]))[1].sentence.endswith("and one repeat tells no error.")


def test_a_best_view_that_is_not_above_blind_is_not_chosen() -> None:
    """Returns and scores can order views differently where the anchors vary between repeats."""
    table, _ = judged(np.array([[-5.0], [-2.0], [-5.2]]) + NOISE)
    table[0] = replace(table[0], score_low=-0.1, verdict="not above blind")
    verdict = scene_verdict("scene", table, 0.95, 12)
    assert (verdict.kind, verdict.keys) == ("not separated", ["scene-b", "scene-a", "scene-c"])
    assert verdict.more_repeats == 12 - NOISE.shape[1]
    assert "; about 9 more repeats would tell the first two apart." in verdict.sentence


def test_score_is_zero_at_blind_and_one_at_the_expert() -> None:
    """Within each repeat, whatever that repeat's episodes are worth."""
    blind, expert = np.array([-10.0, -20.0, -7.0]), np.array([-1.0, -3.0, -2.0])
    mixed = results(np.array([blind, expert, (blind + expert) / 2]))
    mixed.anchors.update(blind=blind, expert=expert)
    assert mixed.scores == pytest.approx(np.array([[0.0] * 3, [1.0] * 3, [0.5] * 3]))


def test_relabelling_permutes_the_table() -> None:
    values = np.array([[-5.0], [-2.0], [-4.0]]) + NOISE
    here, there = judged(values)[0], judged(values[[2, 0, 1]])[0]
    new_key = {"scene-a": "scene-b", "scene-b": "scene-c", "scene-c": "scene-a"}
    assert [new_key[row.key] for row in here] == [row.key for row in there]
    for mine, other in zip(here, there, strict=True):
        assert (mine.rank, mine.verdict) == (other.rank, other.verdict)
        assert mine.return_low == pytest.approx(other.return_low)
        assert mine.difference_high == pytest.approx(other.difference_high)
