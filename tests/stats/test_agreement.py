"""Signs of differences, ours and people's."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.stats.agreement import Compared, Ranking, agreements, compare
from pipeline.study.subjects import read_subjects

ROOT = Path(__file__).resolve().parents[2]
ROWS = read_subjects(ROOT / "data/reference/subjects.csv")
LIKE_PEOPLE = {"panda_1dof": 1.0, "panda_2dof": 1.0, "panda_2dof_obstacle": 1.0}


def ranking(
    difference: float, turned: bool, first: tuple[float, float], second: tuple[float, float]
) -> Ranking:
    """A ranking in which the first view returns ``difference`` more; ``turned`` names the pair backwards."""
    views = {"a": first, "b": second}
    pair = {
        "first": "a",
        "second": "b",
        "difference": difference,
        "low": difference - 0.5,
        "high": difference + 2,
    }
    if turned:
        pair = {
            "first": "b",
            "second": "a",
            "difference": -difference,
            "low": -difference - 2,
            "high": -difference + 0.5,
        }
    places = {key: {"theta_deg": t, "phi_deg": p} for key, (t, p) in views.items()}
    return Ranking.model_validate({"viewpoints": places, "pairs": [pair]})


def found(differences: dict[str, float], turned: bool = False) -> list[Compared]:
    places = {t.scene: ((t.first_theta, t.first_phi), (t.second_theta, t.second_phi)) for t in ROWS}
    return compare(ROWS, {s: ranking(d, turned, *places[s]) for s, d in differences.items()})


@pytest.mark.parametrize("turned", [False, True])
def test_three_equal_signs_come_by_chance_once_in_eight(turned: bool) -> None:
    compared = found(LIKE_PEOPLE, turned)
    assert all((row.ours, row.low, row.high, row.same_sign) == (1.0, 0.5, 3.0, True) for row in compared)
    assert all(row.settled for row in compared)
    assert [(a.measure, a.tasks, a.agree, a.chance) for a in agreements(compared)] == [
        ("time", 3, 3, pytest.approx(1 / 8)),
        ("distance error", 3, 3, pytest.approx(1 / 8)),
    ]


def test_one_sign_that_differs_is_counted() -> None:
    compared = found({**LIKE_PEOPLE, "panda_2dof": -2.5})
    assert [(a.agree, a.chance) for a in agreements(compared)] == [(2, pytest.approx(0.5))] * 2


def test_a_direction_that_is_not_settled_leans_and_is_not_counted() -> None:
    compared = found({**LIKE_PEOPLE, "panda_2dof": -0.4})
    assert [(a.tasks, a.agree, a.leaning, a.chance) for a in agreements(compared)] == [(2, 2, 1, 0.25)] * 2
    leaning = [row for row in compared if not row.settled]
    assert [(row.scene, row.same_sign) for row in leaning] == [("panda_2dof", False)] * 2
    none = agreements(found({"panda_2dof": -0.4}))
    assert [(a.tasks, a.leaning, a.chance) for a in none] == [(0, 1, None)] * 2


def test_a_scene_that_is_not_ranked_says_nothing() -> None:
    compared = found({"panda_1dof": 1.0})
    assert [row.same_sign for row in compared] == [True, True, None, None, None, None]
    assert [(a.tasks, a.chance) for a in agreements(compared)] == [(1, 0.5), (1, 0.5)]


def test_the_papers_p_values_after_holm() -> None:
    """By hand, over the six tests of its Table 2."""
    adjusted = {(row.scene, row.measure): row.p_holm for row in found({})}
    assert adjusted["panda_2dof", "distance error"] == pytest.approx(6 * 0.00036)
    assert adjusted["panda_2dof_obstacle", "distance error"] == pytest.approx(5 * 0.00078)
    assert adjusted["panda_2dof_obstacle", "time"] == pytest.approx(4 * 0.021)
    assert adjusted["panda_1dof", "distance error"] == pytest.approx(3 * 0.034)
    assert adjusted["panda_2dof", "time"] == pytest.approx(
        3 * 0.034
    )  # 2 * 0.044, but never below the one before
    assert adjusted["panda_1dof", "time"] == pytest.approx(0.149)


@pytest.mark.parametrize("text", ["a,b\n1,2\n", "source,scene\nliu\n,,,\n"])
def test_a_foreign_table_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "subjects.csv"
    path.write_text(text)
    with pytest.raises(BelvedereError, match=r"subjects\.csv holds no table of people's means"):
        read_subjects(path)
    with pytest.raises(BelvedereError, match="is missing"):
        read_subjects(tmp_path / "none.csv")
