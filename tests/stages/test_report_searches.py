"""The page's section on searches: the answer, the map, the finalists, and every candidate."""

from __future__ import annotations

import html as markup
import re
import shutil
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from PIL import Image

from pipeline.contract.errors import BelvedereError
from pipeline.reporting.searches import read_searches, search_pages
from pipeline.reporting.sphere import on_map
from tests.stages.report_page import TABLES, Page, build, rows
from tests.stages.report_study import VIEWS, write_study
from tests.stages.search_study import SCENE, Study, write_json

OFF = ("theta_deg", "phi_deg", "right_m", "up_m", "back_m", "turn_deg", "move_m", "change", "low", "high")
OFFSETS = (
    (1, 0, 0, 0, 0, 1, 0, -0.012, -0.03, 0.01),
    (0, -1, 0, 0, 0, 1, 0, -0.034, -0.06, -0.01),
    (5, 0, 0, 0, 0, 5, 0, -0.31, -0.4, -0.2),
    (0, 0, 0.05, 0, 0, 0, 0.05, 0.02, -0.01, 0.05),
)
PUBLISHED = {".json": "search.json", ".csv": "candidates.csv", "_map.csv": "map.csv"}


def publish(found: Path, folder: Path) -> None:
    """As `./run search` does."""
    (folder / "pictures").mkdir(parents=True)
    for ending, name in PUBLISHED.items():
        shutil.copyfile(found / f"{SCENE}{ending}", folder / name)


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A finished search's published folder, and what its stage said."""
    here, out = tmp_path_factory.mktemp("search"), tmp_path_factory.mktemp("published") / SCENE
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(here)
        study = Study()
        study.blind_to = {f"{SCENE}-c24"}
        last = study.run()[-1]
        publish(here / "search/found", out)
    offsets = [dict(zip(OFF, row, strict=True)) for row in OFFSETS]
    (out / "mounting").mkdir()
    for key in last["finalists"][:2]:
        angles = {name: last["candidates"][key][name] for name in ("theta_deg", "phi_deg")}
        write_json(out / "mounting" / f"{key}.json", {**angles, "repeats": 3, "offsets": offsets})
    stale = {"theta_deg": 1, "phi_deg": 1, "repeats": 3, "offsets": offsets}  # of a place that it had before
    write_json(out / "mounting" / f"{last['finalists'][2]}.json", stale)
    for key in last["finalists"][:5]:
        Image.new("RGB", (64, 48), "red").save(out / "pictures" / f"{key}.png")
    return out, last


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory, said: tuple[Path, dict[str, Any]]) -> tuple[str, Path]:
    """The page of a study with a search."""
    folder = tmp_path_factory.mktemp("study")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("BELVEDERE_SCRATCH", str(folder / "scratch"))
        write_study(folder, {"panda_2dof": VIEWS["panda_2dof"]})
        assert 'id="searches"' not in build()
        shutil.copytree(said[0], folder / "reports/searches" / SCENE)
        return build(), folder


def test_it_says_the_answer_and_is_linked(page: tuple[str, Path], said: tuple[Path, dict[str, Any]]) -> None:
    found = Page(page[0])
    assert "#searches" in found.values("href")
    sentence = " ".join(said[1]["answer"]["sentence"].split())
    assert sentence in " ".join(found.text.replace("\u00a0", " ").split())


def test_finalists_stand_in_their_order_with_the_stage_s_numbers(
    page: tuple[str, Path], said: tuple[Path, dict[str, Any]]
) -> None:
    table = rows(page[0], f"Finalists of {SCENE}")
    expected = [
        (row["key"].removeprefix(f"{SCENE}-"), f"{row['score_mean']:.2f}") for row in said[1]["viewpoints"]
    ]
    assert [(row[1], row[4]) for row in table] == expected


def test_every_candidate_has_a_line_finalists_first(
    page: tuple[str, Path], said: tuple[Path, dict[str, Any]]
) -> None:
    table = rows(page[0], f"Candidates of {SCENE}")
    assert len(table) == len(said[1]["candidates"])
    assert [row[2].split()[0] for row in table[:7]] == ["finalist"] * 6 + ["dropped"]
    assert any(row[2].startswith("cannot see") for row in table)


def test_the_map_has_a_mark_for_each_candidate_and_says_the_finalists(
    page: tuple[str, Path], said: tuple[Path, dict[str, Any]]
) -> None:
    svg = re.search(r'<svg[^>]*aria-label="(Candidates of[^"]*)".*?</svg>', page[0], re.DOTALL)
    assert svg is not None
    alt = markup.unescape(svg[1])
    for row in said[1]["viewpoints"]:
        assert f"{row['key'].removeprefix(SCENE + '-')} (" in alt
    assert len(re.findall(r"<use ", svg[0])) >= len(said[1]["candidates"])
    assert set(re.findall(r"#[0-9a-f]{6}\b", svg[0])) == set()  # colours are the page's


def test_reasons_of_places_ruled_out_are_counted(page: tuple[str, Path]) -> None:
    assert "the table hides a target (1)" in Page(page[0]).text


def test_finalists_pictures_are_shown_where_they_are(
    page: tuple[str, Path], said: tuple[Path, dict[str, Any]]
) -> None:
    section = page[0].split('id="searches"')[1].split("</section>")[0]
    assert section.count("<img") == 5


def test_the_worst_direction_of_each_offset_is_told(
    page: tuple[str, Path], said: tuple[Path, dict[str, Any]]
) -> None:
    table = rows(page[0], f"Mounting in {SCENE}")
    assert len(table) == 2
    assert [cell.replace("−", "-") for cell in table[0][1:-1:2]] == [
        "-0.03",
        "-0.31",
        "0.02",
    ]
    exported = pl.read_csv(page[1] / TABLES / "search_mounting.csv")
    assert len(exported) == 2 * len(OFFSETS)


def test_its_tables_are_exported(page: tuple[str, Path], said: tuple[Path, dict[str, Any]]) -> None:
    candidates = pl.read_csv(page[1] / TABLES / "search_candidates.csv")
    assert candidates["candidate"].to_list() == list(said[1]["candidates"])
    finalists = pl.read_csv(page[1] / TABLES / "search_finalists.csv")
    assert finalists["key"].to_list() == [row["key"] for row in said[1]["viewpoints"]]


def test_an_open_search_says_how_it_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    study = Study()
    study.train(study.look()["needed"])
    study.look()
    publish(Path("search/found"), Path("reports/searches") / SCENE)
    (found,) = search_pages(read_searches(Path("reports/searches")), [], Path("reports/searches"))
    search = found.results.found
    assert search.open and search.answer is None and found.thumbnails == {}
    assert "12 of 24 candidates left" in search.progress


def test_a_damaged_map_is_told(tmp_path: Path, said: tuple[Path, dict[str, Any]]) -> None:
    shutil.copytree(said[0], tmp_path / SCENE)
    (tmp_path / SCENE / "map.csv").write_text("theta_deg,phi_deg,mean,sd\n1,2,three,4\n")
    with pytest.raises(BelvedereError, match=r"map.csv holds no map .*run search reach"):
        read_searches(tmp_path)


def test_the_map_has_the_zenith_in_its_middle_and_the_front_below() -> None:
    assert on_map(45, 90) == pytest.approx((0, 0))
    assert on_map(0, 0) == pytest.approx((0, -90))
    assert on_map(90, 0) == pytest.approx((90, 0), abs=1e-12)
