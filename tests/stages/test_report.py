"""The report page: self-contained, complete, true to the tables, the same bytes again."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import polars as pl
import pytest

from pipeline import report
from pipeline.contract.errors import BelvedereError
from pipeline.reporting.numbers import at_most, interval
from pipeline.reporting.tried import COLUMNS, parameters_digest
from pipeline.storage.artefacts import read_json, write_json
from tests.stages.report_page import FOLDERS, TABLES, Page, rows
from tests.stages.report_page import build as build_page
from tests.stages.report_study import VIEWS, write_pictures, write_study

REPOSITORY = Path(report.__file__).parents[1]
Build = Callable[[], str]


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of two scenes, written once."""
    folder = tmp_path_factory.mktemp("study")
    fetch = dict(list(VIEWS["fetch_reach"].items())[:5])
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        write_study(folder, {"fetch_reach": fetch, "panda_2dof": VIEWS["panda_2dof"]})
    return folder


@pytest.fixture(scope="module")
def html(study: Path) -> str:
    """The study's page."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(study)
        patch.setenv("BELVEDERE_SCRATCH", str(study / "scratch"))
        return build_page()


@pytest.fixture
def build(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Build:
    """A copy of the study as working directory; calling it runs the stage and reads the page."""
    shutil.copytree(study, tmp_path, dirs_exist_ok=True, ignore=shutil.ignore_patterns("index.html"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(tmp_path / "scratch"))
    return build_page


def test_page_is_balanced_and_loads_nothing(html: str) -> None:
    page = Page(html)
    for _, name, value in page.attributes:
        if name in ("src", "srcset"):
            assert value.startswith("data:image/")
        if name == "href":
            assert value.startswith("#")
    assert "script" not in {tag for tag, _, _ in page.attributes}
    assert "<script" not in html and "@import" not in html and "url(http" not in html
    assert not re.search(r"https?://|style=", html)
    assert all(page_alt for tag, name, page_alt in page.attributes if (tag, name) == ("img", "alt"))


def test_identifiers_are_unique_and_every_link_has_its_place(html: str) -> None:
    page = Page(html)
    names = page.values("id")
    assert len(names) == len(set(names))
    links = {value[1:] for value in page.values("href")} | set(re.findall(r"url\(#([^)]+)\)", html))
    assert links <= set(names)


def test_security_policy_allows_this_style_and_no_other(html: str) -> None:
    style = re.search(r"<style>(.*?)</style>", html, re.DOTALL)
    assert style is not None
    digest = base64.b64encode(hashlib.sha256(style[1].encode()).digest()).decode()
    policy = next(v for v in Page(html).values("content") if "default-src" in v)
    assert f"style-src 'sha256-{digest}'" in policy
    assert "unsafe" not in policy


def test_table_rows_are_the_rankings_numbers(html: str, study: Path) -> None:
    rows = Page(html).rows
    named = set()
    for scene in ("panda_2dof", "fetch_reach"):
        for key, row in read_json(study / f"reports/rankings/{scene}.json", "")["viewpoints"].items():
            named.add(key)
            cells = [" ".join(cell.replace("−", "-").split()) for cell in rows[key]]
            out = "" if row["out_after"] is None else f" out after {row['out_after']} repeats"
            assert [cells[0], cells[3]] == [str(row["rank"]), row["state"] + out]
            assert [cells[4], cells[8]] == [f"{row[k]:.2f}" for k in ("score_mean", "return_mean")]
            assert cells[9] == f"{row['return_low']:.2f} to {row['return_high']:.2f}"
            if row["behind_leader"] is None:
                assert cells[6:8] == ["–", "–"]
            else:
                assert cells[6] == f"{row['behind_leader']:.2f}"
                assert cells[7] == f"{row['behind_low']:.2f} to {row['behind_high']:.2f}"
            assert cells[10:] == [str(row["repeats"]), str(row["failed"])]
    assert set(rows) == named
    assert len(named) == 8


def test_plots_say_the_tables_numbers(html: str, study: Path) -> None:
    labels = [label.replace("−", "-") for label in Page(html).values("aria-label")]
    ranking = read_json(study / "reports/rankings/panda_2dof.json", "")
    row = ranking["viewpoints"]["panda_2dof-b"]
    score = f"b {row['score_mean']:.2f} ({row['score_low']:.2f} to {row['score_high']:.2f})"
    behind = f"b {row['behind_leader']:.2f} ({row['behind_low']:.2f} to {row['behind_high']:.2f})"
    looks = [look["within"] for look in ranking["race"]["looks"]]
    race = "; ".join(
        f"after {3 + n} repeats a leads, best or within {at_most(x)}" for n, x in enumerate(looks)
    )
    assert [sum(said in label for label in labels) for said in (score, behind, race)] == [1, 1, 1]
    curve = pl.read_csv(study / "reports/branches/panda_2dof/panda_2dof-b/controller.csv")
    first, last = (curve.filter(pl.col("generation") == n)["mean"].mean() for n in (0, 15))
    said = f"view b: mean return from {first:.2f} m at the start to {last:.2f} m"
    assert sum(said in label for label in labels) == 2  # the record is made of the same numbers


def test_scenes_stand_in_the_order_of_params_and_one_not_ranked_is_named(build: Build) -> None:
    Path("params.yaml").write_text(
        Path("params.yaml").read_text().replace("\nscenes:\n", "\nscenes:\n  panda_1dof: {frames: 50}\n")
    )
    page = Page(build())
    places = [name for name in page.values("id") if name.startswith("scene-")]
    assert places == ["scene-fetch_reach", "scene-panda_2dof"]
    assert "dvc repro ranking@panda_1dof" in page.text


def test_same_inputs_give_the_same_bytes_in_another_process(html: str, study: Path) -> None:
    flags = [word for name, folder in FOLDERS.items() for word in (f"--{name}", str(folder))]
    environment = {
        **os.environ,
        "PYTHONPATH": str(REPOSITORY),
        "PYTHONHASHSEED": "5",
        "BELVEDERE_SCRATCH": str(study / "scratch"),
    }
    command = [sys.executable, "-m", "pipeline.report", *flags, "--out", "again.html", "--tables", "again"]
    subprocess.run(command, cwd=study, env=environment, check=True)
    assert (study / "again.html").read_bytes() == html.encode()


def test_lengths_are_written_in_centimetres(build: Build) -> None:
    path = Path("reports/branches/panda_2dof/study/vae.json")
    content = json.loads(path.read_text())
    write_json(path, {**content, "probe_mlp_target_m_mean": 0.07654})
    assert ">7.7<" in build()


def test_anchors_that_make_a_ranking_say_little_are_told_in_a_sentence(html: str, build: Build) -> None:
    little, missed = "sight has little to give", "the expert comes within 2 cm in only 80%"
    assert not any(words in Page(html).text for words in (little, missed))
    path = Path("reports/anchors/panda_2dof.json")
    content = json.loads(path.read_text())
    close = content["expert_mean"] - 0.1 * (content["expert_mean"] - content["no_op_mean"])
    write_json(path, {**content, "blind_mean": close, "expert_within_2cm_share_mean": 0.8})
    text = Page(build()).text
    assert text.count(little) == text.count(missed) == 1


def test_absent_pictures_are_named_with_the_stage_that_makes_them(build: Build) -> None:
    for name in ("view/view.png", "view/view_64.png", "reconstructions.png", "clip.webp"):
        Path("reports/pictures/fetch_reach-b", name).unlink()
    text = Page(build()).text
    for stage, times in (("frames", 2), ("vae", 1), ("evaluation", 1)):
        sentence = f"picture not on this machine; dvc repro {stage}@fetch_reach-b makes it"
        assert text.count(sentence) == times


def test_branch_that_no_ranking_names_stays_out(html: str, build: Build) -> None:
    write_pictures(Path("reports/pictures/panda_2dof-z"), (10, 10))
    lingering = Path("reports/branches/panda_2dof/panda_2dof-z")
    lingering.mkdir()
    (lingering / "vae.json").write_text("not even JSON")
    assert build() == html


def test_seconds_are_shown_where_they_were_recorded(html: str, build: Build) -> None:
    assert "not recorded on this machine" in html
    folder = Path("scratch/seconds")
    for stage, seconds in (("vae@panda_2dof-a", 61.4), ("vae@removed", 7777.0)):
        write_json(folder / f"{stage}.json", {"stage": stage, "seconds": seconds, "machine": "a machine"})
    html = build()
    assert "<td>61</td>" in html and "61 s in all on a machine" in html
    assert "7777" not in html


def test_a_run_from_zero_is_shown_where_one_is_kept(html: str, build: Build) -> None:
    assert 'id="from-zero"' in html and rows(html, "Findings from zero")
    Path("reports/paper/about.json").unlink()
    page = build()
    assert "from zero" not in page and not (TABLES / "claims_from_zero.csv").exists()
    assert rows(page, "Findings") == rows(html, "Findings")


def test_a_scene_that_the_record_lacks_is_named(html: str, build: Build) -> None:
    assert "Not in it" not in html
    about = read_json(Path("reports/paper/about.json"), "")
    write_json(Path("reports/paper/about.json"), about | {"scenes": ["panda_2dof"]})
    assert "Not in it: fetch_reach." in build()


def test_a_record_that_is_cut_short_is_told(build: Build) -> None:
    Path("reports/paper/rankings/panda_2dof.json").unlink()
    with pytest.raises(BelvedereError, match="git checkout reports/paper"):
        build()


def test_viewpoints_that_experiments_tried_are_shown(
    html: str, build: Build, capsys: pytest.CaptureFixture[str]
) -> None:
    assert 'id="tried"' not in html
    digest = parameters_digest("panda_2dof")
    rows = [
        (name, "panda_2dof", 45.0, phi, "quick", digest, repeat, -2.0 - repeat, score + 0.05 * repeat)
        for name, phi, score in (("low-sun", 30.0, 0.4), ("high-sun", 60.0, 0.7))
        for repeat in range(3)
    ]
    pl.DataFrame(rows, schema=COLUMNS, orient="row").write_csv("data/tried.csv")
    page = Page(build())
    assert page.text.index("high-sun") < page.text.index("low-sun")  # best first
    table = pl.read_csv("reports/tables/tried.csv")
    assert table["score_mean"].to_list() == pytest.approx([0.75, 0.45])
    assert interval(table["score_low"][0], table["score_high"][0]) in page.text
    assert any("(45°, 60°) 0.75; (45°, 30°) 0.45" in label for label in page.values("aria-label"))
    params = Path("params.yaml").read_text()
    assert params.count("seed: 1\n") == 1
    Path("params.yaml").write_text(params.replace("seed: 1\n", "seed: 2\n"))
    assert 'id="tried"' not in build()  # of another seed than the page says
    assert "left out of the page: high-sun, low-sun in data/tried.csv" in capsys.readouterr().err
    Path("data/tried.csv").write_text("a,b\n1,2\n")
    with pytest.raises(BelvedereError, match=r"pipeline\.reporting\.gather --out data/tried\.csv"):
        build()


@pytest.mark.parametrize("stage", ["vae", "mdnrnn", "evaluation"])
def test_a_table_of_another_viewpoint_than_the_rankings_is_refused(build: Build, stage: str) -> None:
    path = Path(f"reports/branches/panda_2dof/study/{stage}.json")
    write_json(path, json.loads(path.read_text()) | {"phi_deg": 30.0})
    message = (
        rf"{stage}\.json is of \('panda_2dof', 45\.0, 30\.0\).*dvc repro {stage}@study ranking@panda_2dof"
    )
    with pytest.raises(BelvedereError, match=message):
        build()


def test_single_repeat_shows_no_interval(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, build: Build
) -> None:
    folder = tmp_path / "single"
    folder.mkdir()
    monkeypatch.chdir(folder)
    write_study(folder, {"panda_2dof": VIEWS["panda_2dof"]}, most=1)
    html = build()
    assert all(cells[5] == cells[9] == "–" for cells in Page(html).rows.values())


def test_duplicate_is_named(build: Build) -> None:
    path = Path("reports/rankings/panda_2dof.json")
    content = json.loads(path.read_text())
    content["viewpoints"]["panda_2dof-b"]["duplicates"] = ["study"]
    write_json(path, content)
    assert "same as study" in Page(build()).rows["panda_2dof-b"][1]


@pytest.mark.parametrize(
    ("path", "content", "says"),
    [
        ("rankings/panda_2dof.json", "{", "no JSON file"),
        ("rankings/panda_2dof.json", '{"scene": "panda_2dof"}', "confidence is not valid"),
        ("branches/panda_2dof/study/vae.json", None, "dvc repro vae@study"),
        ("branches/panda_2dof/study/vae.json", "{}", "dvc repro vae@study"),
        ("branches/panda_2dof/study/controller.csv", "a,b\n1,2\n", "no learning curve"),
        (
            "branches/panda_2dof/study/controller.csv",
            "repeat,generation,frames,mean,best\n",
            "curves of 0 repeats",
        ),
        ("anchors/panda_2dof.json", None, "dvc repro anchors@panda_2dof"),
        ("pictures/study/view/view.png", "no picture", "dvc repro frames@study"),
        ("pictures/study/clip.webp", "no clip", "dvc repro evaluation@study"),
    ],
)
def test_bad_input_is_told_in_a_sentence(build: Build, path: str, content: str | None, says: str) -> None:
    file = Path("reports") / path
    if content is None:
        file.unlink()
    else:
        file.write_text(content)
    with pytest.raises(BelvedereError, match=re.escape(says)) as caught:
        build()
    assert str(file) in str(caught.value)
    assert not Path("reports/index.html").exists()


def test_nothing_ranked_is_told(build: Build) -> None:
    for file in Path("reports/rankings").glob("*.json"):
        file.unlink()
    with pytest.raises(BelvedereError, match="holds a ranking of none of the scenes"):
        build()


def test_baselines_are_the_rankings(html: str, study: Path) -> None:
    for scene in ("panda_2dof", "fetch_reach"):
        ranked = read_json(study / f"reports/rankings/{scene}.json", "")
        cells = rows(html, f"Baselines of {scene}")
        order = sorted(ranked["viewpoints"], key=lambda key: ranked["viewpoints"][key]["rank"])
        assert len(cells) == len(ranked["baselines"])
        for row, found in zip(cells, ranked["baselines"], strict=True):
            assert row[1 : 1 + len(order)] == [f"{found['values'][key]:.3g}" for key in order]
            assert row[1 + len(order)].replace("−", "-") == f"{found['tau']:.2f}"


def test_every_table_has_its_twins(html: str, study: Path) -> None:
    """Unrounded, the same numbers as on the page; the ranking's are those of the ranking stage."""
    names = {path.stem for path in (study / TABLES).iterdir()}
    expected = (
        "ranking answers race pairs anchors learning world_models baselines effects claims people agreements "
        "people_implied operator coverage learning_from_zero claims_from_zero"
    )
    assert names == set(expected.split())
    for name in names:
        rows = json.loads((study / TABLES / f"{name}.json").read_text(encoding="utf-8"))
        table = pl.read_csv(study / TABLES / f"{name}.csv", infer_schema_length=None)
        assert table.columns == list(rows[0]) and table.height == len(rows)
    for row in json.loads((study / TABLES / "ranking.json").read_text()):
        ranked = read_json(study / f"reports/rankings/{row['scene']}.json", "")["viewpoints"][row["view"]]
        lists = ("duplicates", "misses")
        assert {key: row[key] for key in ranked if key not in lists} == {
            key: value for key, value in ranked.items() if key not in lists
        }
        assert [row[key] for key in lists] == [" ".join(ranked[key]) for key in lists]
