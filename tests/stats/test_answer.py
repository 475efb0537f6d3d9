"""Answers and their words, on races whose outcome is known."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.contract.viewpoints import Viewpoint
from pipeline.stats.answer import Answer, answer, race_part
from pipeline.stats.branches import Results
from pipeline.stats.messages import progress, sentence
from pipeline.stats.race import Rules
from pipeline.stats.ranks import Ranked, rank
from pipeline.stats.replay import Race, replay
from pipeline.storage.sight import Sight

RULES = Rules(first=3, most=20, tolerance=0.05, probability=0.008)
NOISE = np.array([[0.01, -0.01, 0.0], [-0.01, 0.0, 0.01], [0.0, 0.01, -0.01]])


def results(scores: list[np.ndarray], unseen: str = "") -> Results:
    """Views a, b, c, … at pans 0°, 10°, 20°, … of scene `desk`; target-blind at -10, expert at 0."""
    keys = [f"desk-{letter}" for letter in "abcdef"[: len(scores)]]
    return Results(
        branches={key: Viewpoint(scene="desk", theta=10.0 * i, phi=5.0) for i, key in enumerate(keys)},
        duplicates={key: [] for key in keys},
        returns={key: 10 * np.asarray(own) - 10 for key, own in zip(keys, scores, strict=True)},
        sight={key: Sight(0.1, 0.2, ["tip"] if key[-1] in unseen else []) for key in keys},
        anchors={"no_op": np.full(3, -12.0), "blind": np.full(3, -10.0), "expert": np.zeros(3)},
        provenance={key: {} for key in keys},
    )


def judged(
    scores: list[np.ndarray], unseen: str = "", rules: Rules = RULES
) -> tuple[Answer, list[Ranked], Race | None]:
    found = results(scores, unseen)
    raced = [found.scores[key] for key in found.seen]
    race = replay(raced, rules) if raced else None
    rows = rank(found, race, 0.95)
    return answer("desk", race, rows, 0.95, raced), rows, race


def around(*means: float) -> list[np.ndarray]:
    return [mean + NOISE[view % 3] for view, mean in enumerate(means)]


def test_alone() -> None:
    found, rows, race = judged(around(0.5, 0.8, 0.6))
    assert (found.kind, found.keys, found.within, found.sure) == ("alone", ["desk-b"], 0.0, True)
    assert [(row.key, row.rank, row.state, row.out_after) for row in rows] == [
        ("desk-b", 1, "leader", None),
        ("desk-c", 2, "not the best", 3),
        ("desk-a", 3, "not the best", 3),
    ]
    assert rows[0].behind_leader is None
    assert rows[1].behind_leader == pytest.approx(0.2)
    assert 0 < (rows[1].behind_low or 0) < 0.2 < (rows[1].behind_high or 0)
    assert race is not None and race_part(race, results(around(0.5, 0.8, 0.6)).seen)["out"] == {
        "desk-a": 3,
        "desk-c": 3,
    }
    most = np.ceil(100 * (found.lead_high or 0)) / 100
    assert sentence(found) == (
        "Put the camera at (10°, 5°): b is the best of the 3 views (95 % sure). "
        f"It leads by 0.20, at most {most:.2f}."
    )
    assert progress(found) == (
        "desk, repeat 3 of at most 20: b leads; out: c (after 3), a (after 3). No other view is left."
    )


def test_tolerance() -> None:
    loose = Rules(3, 20, 0.1, 0.008)
    found, _, race = judged(around(0.8, 0.81, 0.3, 0.79), rules=loose)
    assert race is not None and (found.kind, found.keys) == ("tolerance", ["desk-b", "desk-a", "desk-d"])
    assert sentence(found) == (
        f"Put the camera at (10°, 5°): b is the best view or within {np.ceil(100 * found.within) / 100:.2f} "
        "of the best (95 % sure). a and d may be as good; c is not the best."
    )
    assert found.forecast is None


def test_either() -> None:
    found, _, _ = judged(around(0.8, 0.801, 0.3), rules=Rules(3, 20, 0.2, 0.008))
    assert (found.kind, found.keys) == ("either", ["desk-b", "desk-a"])
    assert sentence(found) == (
        "Put the camera at (10°, 5°) or at (0°, 5°), choose either: b and a differ by less than 0.2 "
        "(95 % sure). c is not the best."
    )


def test_open_and_ended() -> None:
    found, _, _ = judged(around(0.8, 0.81, 0.3), rules=Rules(3, 20, 0.001, 0.008))
    assert found.kind == "open" and found.forecast and found.forecast % 2 == 0
    assert sentence(found).startswith("So far, put the camera at (10°, 5°): b is the best view or within 0.")
    assert sentence(found).endswith(f"About {found.forecast} more trainings would bring it to 0.001.")
    assert progress(found).startswith(
        "desk, repeat 3 of at most 20: b leads; in the race b, a; out: c (after 3). Best or within 0."
    )
    ended, _, _ = judged(around(0.8, 0.81, 0.3), rules=Rules(3, 3, 0.001, 0.008))
    assert ended.kind == "ended"
    assert f"3 repeats are spent; about {found.forecast} more trainings would bring it to 0.001." in sentence(
        ended
    )


def test_a_view_at_which_the_judge_cannot_see_is_not_in_the_race() -> None:
    found, rows, race = judged(around(0.95, 0.8, 0.6), unseen="a")
    assert race is not None and len(race.last.entered) == 2
    assert (found.kind, found.keys) == ("alone", ["desk-b"])
    last = rows[-1]
    assert (last.key, last.state, last.misses, last.behind_leader) == ("desk-a", "cannot see", ["tip"], None)
    assert "b is the best of the 2 views" in sentence(found)
    assert sentence(found).endswith("From a this judge cannot see the task.")
    assert "; not seen: a." in progress(found)
    one, _, _ = judged(around(0.95, 0.8), unseen="a")
    assert "b is the only view from which this judge sees the task." in sentence(one)
    assert judged(around(0.8))[0].kind == "alone"
    assert sentence(judged(around(0.8))[0]) == "Put the camera at (0°, 5°): a is the only view of desk."


def test_no_view_at_which_the_judge_sees_has_no_answer() -> None:
    found, rows, race = judged(around(0.5, 0.8), unseen="ab")
    assert race is None and (found.kind, found.keys, found.within) == ("cannot see", [], None)
    assert [row.key for row in rows] == ["desk-b", "desk-a"]
    assert sentence(found) == "No answer: this judge cannot see the task from b and a."
    assert race_part(race, [])["leader"] is None


def test_a_judge_that_learned_nothing_has_no_answer() -> None:
    found, _, _ = judged(around(0.001, 0.002), rules=Rules(3, 20, 0.1, 0.008))
    assert (found.kind, found.keys) == ("not above blind", [])
    assert sentence(found) == "No answer: no score of b and a is surely above target-blind."


def test_a_failed_training_takes_the_certainty_until_ten_repeats() -> None:
    rng = np.random.default_rng(1)
    scores = [0.8 + 0.01 * rng.standard_normal(10), 0.75 + 0.01 * rng.standard_normal(10), np.full(3, 0.3)]
    scores[2][1] = -0.1
    found, rows, _ = judged([own[:3] for own in scores[:2]] + scores[2:], rules=Rules(3, 20, 0.001, 0.008))
    assert [row.failed for row in rows] == [0, 0, 1]
    assert not found.sure and "sure)" not in sentence(found)
    assert "since a training of c came out no better than target-blind." in sentence(found)
    few = Rules(10, 10, 0.001, 0.008)
    scores[2] = np.append(scores[2], np.full(7, 0.3))
    later, _, _ = judged(scores, rules=few)
    assert later.sure and "(95 % sure)" in sentence(later)


def test_what_is_printed_as_a_bound_still_holds() -> None:
    for within in (0.0401, 0.049, 0.0501, 0.1):
        found, _, _ = judged(around(0.8, 0.81), rules=Rules(3, 3, 0.001, 0.008))
        shown = sentence(Answer(**{**found.__dict__, "within": within}))
        assert float(shown.split("within ")[1].split()[0]) >= within


def test_a_views_own_interval_is_of_all_its_repeats() -> None:
    scores = around(0.8, 0.3)
    scores[0] = np.append(scores[0], 0.9)
    rows = judged(scores)[1]
    assert [(row.key, row.repeats) for row in rows] == [("desk-a", 4), ("desk-b", 3)]
    assert rows[0].score_mean == pytest.approx(scores[0].mean())
    assert rows[0].return_mean == pytest.approx(10 * scores[0].mean() - 10)
    assert rows[1].behind_leader == pytest.approx(scores[0][:3].mean() - scores[1].mean())
