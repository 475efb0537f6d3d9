"""The cards: where to put the camera, what is still open, and where a judge cannot see."""

from __future__ import annotations

import json
from collections.abc import Callable
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from pipeline.storage.artefacts import write_json
from tests.stages.report_page import Page, build, rows
from tests.stages.report_study import VIEWS, write_study

SCENE = "fetch_reach"
RANKING = Path(f"reports/rankings/{SCENE}.json")
Change = Callable[[dict[str, Any]], None]


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[Change], str]:
    """Changes the ranking of a made-up study and builds the page."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(tmp_path / "scratch"))
    write_study(tmp_path, {SCENE: VIEWS[SCENE]}, study=None)

    def built(change: Change) -> str:
        content = json.loads(RANKING.read_text(encoding="utf-8"))
        change(content)
        write_json(RANKING, content)
        return build()

    return built


def card(html: str) -> str:
    """The text of the scene's card, in one line."""
    article = html.split('<article class="card answer">', 1)[1].split("</article>", 1)[0]
    return " ".join(unescape(Page(f"<article>{article}</article>").text).split())


def test_a_card_is_the_answer_with_its_race(page: Callable[[Change], str]) -> None:
    html = page(lambda content: None)
    content = json.loads(RANKING.read_text(encoding="utf-8"))
    said = card(html)
    assert " ".join(content["answer"]["sentence"].split()) in said
    leader = content["viewpoints"][content["answer"]["keys"][0]]
    assert f"a: score {leader['score_mean']:.2f} ({leader['score_low']:.2f} to " in said
    spent = sum(row["repeats"] for row in content["viewpoints"].values())
    assert f"5 of at most 20 repeats raced, {spent} trainings spent" in said
    assert "Best or within 0.05 (tolerance 0.05)" in said
    assert "Out: c after 3, d after 3 repeats" in said
    assert "c: 1 training at or below target-blind" in said
    assert "Still open" not in said and "./run" not in said
    assert html.count("<figcaption>a: θ = 0°, φ = 30°</figcaption>") == 1


def test_an_open_race_says_what_is_open_and_that_run_goes_on(page: Callable[[Change], str]) -> None:
    def change(content: dict[str, Any]) -> None:
        content["race"]["open"] = True
        content["answer"] |= {"kind": "open", "forecast_trainings": 14}

    said = card(page(change))
    progress = json.loads(RANKING.read_text(encoding="utf-8"))["answer"]["progress"]
    assert f"Still open. {progress} ./run goes on; about 14 more trainings would bring it to 0.05." in said


def test_either_of_two_shows_both(page: Callable[[Change], str]) -> None:
    html = page(lambda content: content["answer"].update(kind="either"))
    assert all(f"<figcaption>{view}: θ" in html for view in ("a", "b"))


def test_what_the_code_misses_is_named_view_by_view(page: Callable[[Change], str]) -> None:
    said = card(page(lambda content: content["viewpoints"][f"{SCENE}-f"].update(misses=["tip"])))
    errs = "a probe errs by 11.3 cm, guessing by 18.7 cm."
    assert f"e cannot be judged: the latent misses tip and target; {errs}" in said
    assert f"f cannot be judged: the latent misses tip; {errs}" in said


def test_a_scene_in_which_no_judge_sees_has_no_race(page: Callable[[Change], str]) -> None:
    nothing = {"open": False, "common": 0, "active": [], "out": {}, "leader": None, "lead_low": None}
    sentence = "This judge cannot see here: no latent holds tip and target."

    def change(content: dict[str, Any]) -> None:
        content["answer"] |= {"kind": "cannot see", "keys": [], "within": None, "sentence": sentence}
        content["race"] = {**nothing, "lead_high": None, "looks": []}
        content |= {"spread": None, "pairs": []}
        for row in content["viewpoints"].values():
            row |= {"state": "cannot see", "behind_leader": None, "behind_low": None, "behind_high": None}
            row |= {"out_after": None, "misses": ["tip - target"]}

    html = page(change)
    assert card(html).startswith(f"{SCENE} {sentence} No race was run, 21 trainings spent")
    assert card(html).count("the latent misses tip - target") == 6
    assert "Score behind the leader" not in html and "The race: " not in html
    assert {row[3] for row in rows(html, f"Ranking of {SCENE}")} == {"✕ cannot see".removeprefix("✕ ")}


def test_a_race_of_one_look_has_no_course(page: Callable[[Change], str]) -> None:
    html = page(lambda content: content["race"].update(looks=content["race"]["looks"][:1]))
    assert "Score behind the leader" in html and "The race: " not in html


def test_a_failure_before_ten_repeats_takes_the_certainty(page: Callable[[Change], str]) -> None:
    said = card(page(lambda content: content["answer"].update(sure=False)))
    assert "No certainty is stated: a training failed" in said


def test_the_start_is_told_as_it_is(page: Callable[[Change], str]) -> None:
    least_squares = (
        "starts from least squares on the rewards of random episodes; the paper trains from scratch"
    )
    assert least_squares in page(lambda content: None)
    params = Path("params.yaml")
    params.write_text(params.read_text(encoding="utf-8").replace("first: rewards", "first: zero"))
    html = page(lambda content: None)
    assert least_squares not in html and "starts from scratch, as in the paper" in html


def test_words_of_the_former_question_are_gone(page: Callable[[Change], str]) -> None:
    html = page(lambda content: None)
    exports = "".join(path.read_text(encoding="utf-8") for path in sorted(Path("reports/tables").iterdir()))
    for word in ("separated", "P(best)", "best_chance", "more repeats", "Hedges", "hedges", "Welch", "welch"):
        assert word not in html and word not in exports
