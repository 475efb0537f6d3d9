"""The report's section on people: without own trials, with synthetic ones, and with few people."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.storage.artefacts import read_json, write_json
from tests.stages.report_page import TABLES, Page, build, rows
from tests.stages.report_study import VIEWS, write_people, write_study

SCENES = {"panda_1dof": VIEWS["panda_1dof"], "panda_2dof": VIEWS["panda_2dof"]}
NONE = "No own trials; published Table 2 only."


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("study")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        write_study(folder, SCENES)
    return folder


@pytest.fixture(autouse=True)
def place(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(study, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(tmp_path / "scratch"))
    return tmp_path


def section(html: str) -> str:
    return html.split('<section id="people"', 1)[1].split("</section>", 1)[0]


def text(html: str) -> str:
    return " ".join(Page(f'<section id="people"{section(html)}</section>').text.split())


def change(**entries: Any) -> dict[str, Any]:
    path = Path("reports/people.json")
    content = read_json(path, "") | entries
    write_json(path, content)
    return content


def test_without_own_trials_the_published_table_stands_alone() -> None:
    html = build()
    assert NONE in text(html) and "ynthetic" not in text(html) and "<svg" not in section(html)
    (source, time, distance, p_time, p_distance) = rows(html, "Means of people")
    assert source == ["Liu et al., 11 people"]
    assert time == ["Task time (s)", "10.66", "12.11", "17.29", "25.94", "17.57", "29.17"]
    assert distance == ["Distance error (cm)", "0.94", "1.56", "1.74", "6.23", "1.22", "5.94"]
    assert p_time == ["p of task time", "0.149", "0.044", "0.021"]
    assert p_distance == ["p of distance error", "0.034", "< 0.001", "< 0.001"]
    assert not {path.stem for path in TABLES.iterdir()} & {"people_tests", "people_learning", "people_course"}


def test_own_trials_stand_in_the_published_layout_with_tests_and_plots(place: Path) -> None:
    write_people(place, participants=8)
    html = build()
    assert NONE not in text(html)
    table = rows(html, "Means of people")
    assert [len(row) for row in table] == [1, 7, 7, 4, 4] * 2
    assert table[5] == ["scripted operator (synthetic), 8 participants"]
    content = read_json(Path("reports/people.json"), "")
    own = [r for r in content["rows"] if r["source"] != "Liu et al." and r["measure"] == "time"]
    assert table[6][1:] == [f"{r[one]:.2f}" for r in own for one in ("first", "second")]
    assert len(rows(html, "Tests of own trials")) == 3 * 6 and len(rows(html, "Next study")) == 6
    labels = [name for name in Page(html).values("aria-label") if "participant(s) under 2 views" in name]
    assert len(labels) == 3
    left_out = content["own"]["left_out"]
    assert left_out and all(f"{count} {reason}" in text(html) for reason, count in left_out.items())
    for name in ("people_tests", "people_learning", "people_course"):
        assert json.loads((TABLES / f"{name}.json").read_text(encoding="utf-8"))


def test_synthetic_data_are_marked_wherever_they_appear(place: Path) -> None:
    write_people(place, participants=8)
    html = section(build())
    marked = re.compile("synthetic|geometry, not people|scripted operator", re.IGNORECASE)
    for svg in re.findall(r"<svg.*?</svg>", html, re.DOTALL):
        assert "synthetic" in svg.split(">", 1)[0] and "synthetic" in svg.split(">", 1)[1]
    for region in ("Tests of own trials", "Next study", "Learning of people", "Scripted operator"):
        caption = html.split(f'aria-label="{region}"', 1)[1].split("</caption>", 1)[0]
        assert marked.search(caption), region
    own = [row for row in rows(html, "People and world model") if row[0] != "Liu et al."]
    assert len(own) == 6 and all("synthetic" in row[0] for row in own)
    assert '<p class="synthetic"><strong>Synthetic.</strong>' in html


def test_people_are_not_called_synthetic_and_few_of_them_are_only_counted(place: Path) -> None:
    write_people(place, participants=3, operator="person")
    html = build()
    said = text(html)
    assert "ynthetic" not in said and "Means and tests are told from 5 people on" in said
    own = [row for row in rows(html, "People and world model") if row[0] == "own trials"]
    assert len(own) == 6 and all(row[4:9] == ["–"] * 5 for row in own)
    assert {tuple(row[5:]) for row in rows(html, "Tests of own trials")} == {("–",) * 7}
    shutil.rmtree(place / "data/sessions")
    write_people(place, participants=6, operator="person")
    html = build()
    assert "Means and tests are told" not in text(html)
    assert all(row[4] != "–" for row in rows(html, "People and world model"))


def test_one_scripted_session_is_shown(place: Path) -> None:
    write_people(place, participants=1)
    html = build()
    own = [row for row in rows(html, "People and world model") if row[0] != "Liu et al."]
    assert all(row[4] != "–" and row[7] == "–" for row in own)  # means, but no test


def test_settled_and_leaning_tasks_are_told_apart() -> None:
    content = change()
    for n, row in enumerate(content["rows"]):
        row |= {"ours": 0.0412, "low": -0.02 if n % 2 else 0.01, "high": 0.09, "same_sign": n != 2}
        row["settled"] = n % 2 == 0
    found = [
        {"source": "Liu et al.", "measure": m, "tasks": t, "agree": t, "chance": c, "leaning": 1}
        for m, t, c in (("time", 1, 0.5), ("distance error", 0, None))
    ]
    change(rows=content["rows"], agreements=found)
    html = build()
    preferred = [row[-1] for row in rows(html, "People and world model")]
    assert preferred == ["yes", "leans yes", "no", "leans yes", "yes", "leans yes"]
    said = text(html)
    assert "Time (Liu et al.): 1 of 1 settled task prefers the same view" in said
    assert "Distance error (Liu et al.): no task is settled." in said
    assert "Only leaning: panda_1dof, distance error (the same view); " in said


@pytest.mark.parametrize(
    ("path", "content", "says"),
    [
        ("reports/people.json", None, "dvc repro people"),
        ("reports/people.json", "{}", "own is not valid"),
        ("data/people/means.parquet", None, "dvc repro people"),
        ("data/people/means.parquet", "no Parquet", "is no Parquet file"),
        ("data/people/course.parquet", "", "dvc repro people"),
    ],
)
def test_what_lacks_or_is_foreign_is_told(path: str, content: str | None, says: str) -> None:
    file = Path(path)
    file.unlink()
    if content is not None:
        file.write_text(content)
    with pytest.raises(BelvedereError, match=re.escape(says)) as caught:
        build()
    assert path in str(caught.value)
