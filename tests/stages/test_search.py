"""The stage search on made-up trainings: whom it keeps, what it asks for, and what it says in the end."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipeline.contract.errors import BelvedereError
from tests.stages.search_study import MAP, SCENE, TABLE, Study, ridge


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_it_halves_and_races_the_finalists_on_fresh_repeats(
    capsys: pytest.CaptureFixture[str],
) -> None:
    study = Study()
    first, *_, last = said = study.run()
    assert first["needed"] == dict.fromkeys(study.views, 1)
    assert [len(one["kept"]) for one in last["rounds"]] == [12, 6]
    assert set(last["rounds"][1]["kept"]) == set(last["finalists"])
    begun = next(one for one in said if one["finalists"])
    assert begun["needed"] == dict.fromkeys(begun["finalists"], 2 + 3) and begun["race"]["looks"] == []
    assert not last["open"] and last["trainings"] == sum(study.repeats.values())
    assert last["answer"]["sentence"] in capsys.readouterr().out


def test_the_answer_is_near_the_best_of_the_map_and_says_how_near() -> None:
    study = Study()
    last = study.run()[-1]
    true = {key: ridge(view.theta, view.phi) for key, view in study.views.items()}
    chosen = last["answer"]["keys"][0]
    among = max(true[key] for key in last["finalists"])
    assert among - true[chosen] <= last["answer"]["within"] or last["answer"]["kind"] == "alone"
    assert max(true.values()) - true[chosen] <= 0.05
    assert "finalist" in last["answer"]["sentence"]


def test_what_chose_the_finalists_does_not_count_for_them() -> None:
    """Scores of the halving's repeats may be anything; the finalists' table does not change."""
    study = Study()
    last = study.run()[-1]
    for key in last["finalists"]:
        file = study.folder / key / "evaluation.json"
        text = file.read_text()
        value = text.split('"return": ')[1].split("}")[0]
        file.write_text(text.replace(value, str(float(value) + 1.0), 1))
    again = study.look()
    assert {row["key"]: row["score_mean"] for row in again["viewpoints"]} == pytest.approx(
        {row["key"]: row["score_mean"] for row in last["viewpoints"]}
    )


def test_nobody_is_asked_for_more_than_one_repeat_a_round_of_halving() -> None:
    study = Study()
    for said in study.run():
        if not said["finalists"]:
            assert all(count <= len(said["rounds"]) + 1 for count in said["needed"].values())


def test_candidates_that_the_judge_does_not_see_from_are_out_at_once() -> None:
    study = Study()
    study.blind_to = set(list(study.views)[:10])
    last = study.run()[-1]
    assert {key for key, row in last["candidates"].items() if row["state"] == "cannot see"} == study.blind_to
    assert all(study.repeats[key] == 1 for key in study.blind_to)
    assert [len(one["kept"]) for one in last["rounds"]] == [7, 6]


def test_where_no_candidate_sees_it_says_so() -> None:
    study = Study()
    study.blind_to = set(study.views)
    last = study.run()[-1]
    assert last["answer"]["kind"] == "cannot see" and not last["open"]
    assert last["trainings"] == len(study.views)


def test_the_budget_of_trainings_ends_it_with_what_was_reached() -> None:
    tie = Study(score=lambda theta, phi: 0.7, sd=0.08, most_trainings=70)
    last = tie.run()[-1]
    assert last["answer"]["kind"] == "ended" and last["trainings"] <= 70
    assert last["answer"]["within"] > 0.05 and last["answer"]["forecast_trainings"] > 0


def test_more_candidates_later_reuse_what_was_done() -> None:
    study = Study()
    half = dict(list(study.views.items())[::2])
    study.place(half)
    assert not study.run()[-1]["open"]
    before = dict(study.repeats)
    study.place(study.views)
    later = study.look()
    assert later["needed"] == {key: 1 for key in study.views if key not in half}
    study.run()
    assert all(study.repeats[key] >= before[key] for key in half)


def test_its_tables_have_a_line_for_each_candidate_and_a_surface_over_their_range() -> None:
    study = Study()
    last = study.run()[-1]
    table = pl.read_csv(TABLE)
    assert table["candidate"].to_list() == list(study.views)
    surface = pl.read_csv(MAP)
    assert surface["theta_deg"].min() <= -85 and surface["theta_deg"].max() >= 85
    near = surface.filter((pl.col("theta_deg") == 30) & (pl.col("phi_deg") == 35)).row(0, named=True)
    assert near["mean"] == pytest.approx(ridge(30, 35), abs=0.1) and near["sd"] < 0.1
    best = surface.sort("mean")["theta_deg", "phi_deg"].row(-1)
    assert abs(best[0] - 30) <= 25 and abs(best[1] - 35) <= 25
    assert last["ruled_out"] == [
        {"theta": 0.0, "phi": -5.0, "distance_m": 1.4, "fov_deg": 40.0, "why": "the table hides a target"}
    ]


def test_the_same_results_give_the_same_bytes() -> None:
    study = Study()
    study.run()
    before = {path: path.read_bytes() for path in MAP.parent.iterdir()}
    study.look()
    assert {path: path.read_bytes() for path in MAP.parent.iterdir()} == before


def test_a_foreign_evaluation_is_refused() -> None:
    study = Study()
    study.train({f"{SCENE}-c01": 1})
    file = study.folder / f"{SCENE}-c01" / "evaluation.json"
    file.write_text(file.read_text().replace('"phi_deg": 1', '"phi_deg": 2'))
    with pytest.raises(
        BelvedereError, match=r"cannot be used: it is of .*search/dvc.yaml:evaluation@reach-c01"
    ):
        study.look()


def test_the_surface_is_flat_where_scores_are(tmp_path: Path) -> None:
    study = Study(score=lambda theta, phi: 0.7, sd=0.02)
    study.run()
    surface = pl.read_csv(MAP)
    assert np.ptp(surface["mean"].to_numpy()) < 0.1


def test_where_the_judge_sees_from_one_candidate_only_the_answer_says_so() -> None:
    study = Study()
    only = max(study.views, key=lambda key: ridge(study.views[key].theta, study.views[key].phi))
    study.blind_to = set(study.views) - {only}
    sentence = study.run()[-1]["answer"]["sentence"]
    assert (
        f"{only.removeprefix('reach-')} is the only candidate from which this judge sees the task."
        in sentence
    )


def test_trainings_that_do_not_suffice_for_a_first_comparison_are_told() -> None:
    study = Study(most_trainings=53)
    with pytest.raises(BelvedereError, match=r"most_trainings = 53 is not valid: 24 candidates take 54"):
        study.look()


def test_it_says_how_many_trainings_and_repeats_are_left() -> None:
    last = Study(most_trainings=60).run()[-1]
    assert last["trainings_left"] == 60 - last["trainings"] >= 0
    assert last["most_repeats"] == 2 + 20 and Study().look()["trainings_left"] is None
