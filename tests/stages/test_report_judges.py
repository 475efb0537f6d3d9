"""The report's section on judges, with networks and without, and the paper's findings beside ours."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

import polars as pl
import pytest

from pipeline.reporting.numbers import fraction, interval, score
from pipeline.storage.artefacts import write_json
from tests.stages.report_page import TABLES, build, rows
from tests.stages.report_rankings import claims, judges
from tests.stages.report_study import VIEWS, write_study
from tests.stages.report_tables import expected

SCENE = "fetch_reach"
NETWORKS = 3  # repeats


def write_networks(folder: Path) -> None:
    """What `dqn` and `ranking` leave where networks were trained, which see no difference between views."""
    for key in VIEWS[SCENE]:
        steps = [
            {"repeat": r, "generation": g, "frames": 1600 * (g + 1), "mean": -9.0 + g / 5, "best": -5.0}
            for r in range(NETWORKS)
            for g in range(25)
        ]
        pl.DataFrame(steps).write_csv(folder / "reports/branches" / SCENE / key / "dqn.csv")
    path = folder / f"reports/rankings/{SCENE}.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    content |= judges(SCENE, VIEWS[SCENE], NETWORKS) | {"claims": claims(SCENE, NETWORKS)}
    write_json(path, content)


@dataclass(frozen=True)
class Built:
    """A page, and what the scene's ranking says."""

    html: str
    ranking: dict
    folder: Path


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Built]:
    """The page of one study, before and after networks were trained."""
    folder = tmp_path_factory.mktemp("judges")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("BELVEDERE_SCRATCH", str(folder / "scratch"))
        scenes = {SCENE: VIEWS[SCENE], "panda_2dof": VIEWS["panda_2dof"]}
        write_study(folder, scenes, participants=7)
        before = built(folder)
        write_networks(folder)
        return {"without": before, "with": built(folder)}


def built(folder: Path) -> Built:
    ranking = json.loads((folder / f"reports/rankings/{SCENE}.json").read_text(encoding="utf-8"))
    return Built(build(), ranking, folder)


def test_without_networks_the_page_says_how_to_train_them(pages: dict[str, Built]) -> None:
    html = pages["without"].html
    assert "DQN not run at this budget" in html
    assert "<code>./run dvc exp run -S budgets.quick.dqn.repeats=3</code>" in html
    findings = rows(html, "Findings")
    assert [row[-1] for row in findings if row[2] != "world model"] == ["not run"] * 3


def test_with_networks_both_judges_have_their_curves(pages: dict[str, Built]) -> None:
    html = pages["with"].html
    assert "DQN not run" not in html
    assert html.count("<figcaption>DQN, θ = ") == html.count("<figcaption>world model, θ = ") == 3


def test_equal_frames_count_what_the_world_model_saw_before(pages: dict[str, Built]) -> None:
    html, folder = pages["with"].html, pages["with"].folder
    frames = float(re.search(r"after equally many frames \((\d+), in training\)", html)[1])
    controller = pl.read_csv(folder / f"reports/branches/{SCENE}/{SCENE}-a/controller.csv")
    networks = pl.read_csv(folder / f"reports/branches/{SCENE}/{SCENE}-a/dqn.csv")
    random_frames = 20 * 50  # episodes by frames, as write_study says
    assert frames == min(controller["frames"].max() + random_frames, networks["frames"].max())
    (row,) = [row for row in rows(html, f"Both judges in {SCENE}") if row[0] == "a"]
    seen = controller.filter(pl.col("frames") + random_frames <= frames)
    last = seen.filter(pl.col("frames") == seen["frames"].max())["mean"].mean()
    assert row[7] == score(last)
    last = networks.filter(pl.col("frames") <= frames).filter(pl.col("frames") == pl.col("frames").max())
    assert row[8] == score(last["mean"].mean())


def test_every_cell_of_every_table_is_a_twins_number(pages: dict[str, Built]) -> None:
    html, folder = pages["with"].html, pages["with"].folder
    regions = set(re.findall(r'role="region" aria-label="([^"]*)"', html))
    wanted = expected(folder / TABLES)
    assert regions - {"Seconds per stage", "Parameters", "Made with"} == set(wanted)
    for region, cells in wanted.items():
        found = rows(html, region)
        if region.startswith("Baselines"):
            found = [row[:-1] for row in found]  # the seconds stand in no table
        if region.startswith("Both judges"):
            found = [row[:-2] for row in found]  # tested by themselves above
        if region.startswith("Findings"):
            cells = sorted(cells, key=lambda row: row[0])
        assert found == cells, region


def test_every_number_in_the_sentences_is_the_rankings(pages: dict[str, Built]) -> None:
    html, ranking = pages["with"].html, pages["with"].ranking
    spread, race = ranking["spread"], ranking["race"]
    assert f"standard deviation {spread['sd']:.3f} ({spread['df']:.0f} degrees of freedom)" in html
    lead = f"{score(race['lead_low'])} to {score(race['lead_high'])}"
    assert f"The lead of a over the best of the others: {lead}." in html
    unit, blind = score(ranking["unit_m"]), score(ranking["blind_m"])
    assert f"A score of 1 is {unit} m of return above target-blind, {blind} m." in html
    card = html.split(f'href="#scene-{SCENE}"', 2)[2].split("</article>", 1)[0]
    row = ranking["viewpoints"][ranking["answer"]["keys"][0]]
    assert f"score {score(row['score_mean'])} ({interval(row['score_low'], row['score_high'])})" in card
    spent = sum(row["repeats"] for row in ranking["viewpoints"].values())
    assert f"{race['common']} of at most {ranking['most']} repeats raced, {spent} trainings spent" in card
    rows_of = json.loads((pages["with"].folder / TABLES / "coverage.json").read_text(encoding="utf-8"))
    worst, least = max(row["wrong"] for row in rows_of), min(row["covered"] for row in rows_of)
    assert f"at most {fraction(worst)} of a kind" in html and f"in at least {fraction(least)}." in html
    ended = json.loads(
        (pages["with"].folder / f"reports/branches/{SCENE}/{SCENE}-a/evaluation.json").read_text()
    )
    assert f"Ends {100 * ended['final_distance_m_mean']:.1f} cm off on average" in html
