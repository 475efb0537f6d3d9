"""The report's section on judges, with networks and without, and the paper's findings beside ours."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from html import unescape
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipeline import ranking, report
from pipeline.contract.artefacts import write_json
from pipeline.reporting.numbers import interval, score
from tests.stages.report_tables import expected
from tests.stages.test_report import FOLDERS, MADE_WITH, PAGE, REPOSITORY, TABLES, VIEWS, align, write_study

SCENE = "fetch_reach"


def write_networks(folder: Path, repeats: int = 3) -> None:
    """What the stage `dqn` leaves: networks that see no difference between views."""
    rng = np.random.default_rng(5)
    for key in VIEWS[SCENE]:
        branch = folder / "reports/branches" / SCENE / key
        rows = [
            {"repeat": r, "return": float(rng.normal(-4.4, 0.2)), "expert_return": -2.6}
            for r in range(repeats)
        ]
        write_json(branch / "dqn.json", {"repeats": rows, "made_with": MADE_WITH})
        steps = [
            {"repeat": r, "generation": g, "frames": 1600 * (g + 1), "mean": -9.0 + g / 5, "best": -5.0}
            for r in range(repeats)
            for g in range(25)
        ]
        pl.DataFrame(steps).write_csv(branch / "dqn.csv")


def rank(folder: Path) -> dict:
    out = folder / f"reports/rankings/{SCENE}.json"
    ranking.main(
        scene=SCENE,
        branches=folder / "reports/branches" / SCENE,
        anchors=folder / f"reports/anchors/{SCENE}.json",
        claims=REPOSITORY / "data/reference/claims.yaml",
        out=out,
        table=folder / "ranking.csv",
    )
    return json.loads(out.read_text())


@dataclass(frozen=True)
class Page:
    """A page, and what the scene's ranking says."""

    html: str
    ranking: dict
    folder: Path


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Page]:
    """The page of one study, before and after networks were trained."""
    folder = tmp_path_factory.mktemp("judges")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("BELVEDERE_SCRATCH", str(folder / "scratch"))
        write_study(folder, {SCENE: VIEWS[SCENE], "panda_2dof": VIEWS["panda_2dof"]})
        before = built(folder)
        write_networks(folder)
        return {"without": before, "with": built(folder)}


def built(folder: Path) -> Page:
    content = rank(folder)
    align(folder)
    report.main(**FOLDERS, out=PAGE, tables=TABLES)
    return Page(Path(PAGE).read_text(encoding="utf-8"), content, folder)


def rows(html: str, label: str) -> list[list[str]]:
    """The cells of the table in the region of that name."""
    table = html.split(f'aria-label="{label}"', 1)[1].split("</table>", 1)[0]
    body = table.split("<tbody>", 1)[1]
    cells = [
        re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.DOTALL) for row in re.split("<tr[^>]*>", body)[1:]
    ]
    return [[unescape(re.sub(r"<[^>]+>", "", cell)).strip() for cell in row] for row in cells]


def test_without_networks_the_page_says_how_to_train_them(pages: dict[str, Page]) -> None:
    html = pages["without"].html
    assert "DQN not run at this budget" in html
    assert "<code>./run dvc exp run -S budgets.quick.dqn.repeats=3</code>" in html
    findings = rows(html, "Findings")
    assert [row[-1] for row in findings if row[2] != "world model"] == ["not run"] * 3


def test_with_networks_both_judges_have_their_curves(pages: dict[str, Page]) -> None:
    html = pages["with"].html
    assert "DQN not run" not in html
    assert html.count("<figcaption>DQN, θ = ") == html.count("<figcaption>world model, θ = ") == 3


def test_equal_frames_count_what_the_world_model_saw_before(pages: dict[str, Page]) -> None:
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


def test_every_cell_of_every_table_is_a_twins_number(pages: dict[str, Page]) -> None:
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
        if region == "Findings":
            cells = sorted(cells, key=lambda row: row[0])
        assert found == cells, region


def test_every_number_in_the_sentences_is_the_rankings(pages: dict[str, Page]) -> None:
    html, ranking = pages["with"].html, pages["with"].ranking
    gap, spread = ranking["gap"], ranking["spread"]
    said = f"A gap of {score(gap['score'])} in score ({score(gap['metres'])} m), were it there, is told with"
    assert f"{said} {gap['repeats_needed']} repeats." in html
    assert f"standard deviation {spread['pooled_sd']:.2f} m ({spread['df']:.1f} degrees of freedom)" in html
    card = html.split(f'href="#scene-{SCENE}"', 2)[2].split("</article>", 1)[0]
    for key in ranking["verdict"]["keys"]:
        row = ranking["viewpoints"][key]
        assert f"score {score(row['score_mean'])} ({interval(row['score_low'], row['score_high'])})" in card
    more = ranking["verdict"]["more_repeats"]
    assert (f"; about {more} more repeats to tell " in card) == (more is not None)
    ended = json.loads(
        (pages["with"].folder / f"reports/branches/{SCENE}/{SCENE}-a/evaluation.json").read_text()
    )
    assert f"Ends {100 * ended['final_distance_m_mean']:.1f} cm off on average" in html
