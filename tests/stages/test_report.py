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
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import polars as pl
import pytest
import yaml
from PIL import Image, ImageDraw

from pipeline import alignment, ranking, report
from pipeline.contract.artefacts import read_json, write_json
from pipeline.contract.errors import BelvedereError
from pipeline.reporting.numbers import chance, interval
from pipeline.reporting.tried import COLUMNS
from pipeline.stats.baselines import BASELINES

REPOSITORY = Path(report.__file__).parents[1]
MADE_WITH = {"device": "cpu", "dtype": "bfloat16", "threads": 2, "torch": "2.13.0", "mujoco": "3.17.0"}
VIEWS = {
    "panda_1dof": {"panda_1dof-a": (90, 45), "panda_1dof-b": (90, 30)},
    "panda_2dof": {"panda_2dof-a": (0, 0), "panda_2dof-b": (90, 0)},
    "panda_2dof_obstacle": {"panda_2dof_obstacle-a": (0, 0), "panda_2dof_obstacle-b": (90, 0)},
    "fetch_reach": {
        f"fetch_reach-{letter}": (theta, phi)
        for letter, (phi, theta) in zip(
            "abcdef", [(p, t) for p in (30, 45) for t in (0, 45, 90)], strict=True
        )
    },
}
PROBES = [
    f"probe_{kind}_{what}_m" for kind in ("linear", "mlp") for what in ("tip", "target", "tip_to_target")
]
SHARES = ["target_seen_share", "frames_target_hidden_share"]
VAE = ["reconstruction_error", "kl_nats", "active_dimensions"]
VOID = {"meta", "img", "source", "br", "hr", "link", "input"}


def write_study(
    folder: Path,
    scenes: dict[str, dict[str, tuple[float, float]]],
    study: tuple[str, float, float] = ("panda_2dof", 45, 15),
    repeats: int = 3,
) -> None:
    """A study's tables and pictures as the stages leave them, with made-up numbers."""
    rng = np.random.default_rng(7)
    _write_params(folder, scenes, study, repeats)
    for scene, views in scenes.items():
        views = {**views, **({"study": study[1:]} if scene == study[0] else {})}
        _write_anchors(folder, scene, repeats)
        for place, (key, angles) in enumerate(views.items()):
            _write_branch(folder / "reports/branches" / scene / key, scene, angles, place, repeats, rng)
            _write_pictures(folder / "reports/pictures" / key, angles)
        ranking.main(
            scene=scene,
            branches=folder / "reports/branches" / scene,
            anchors=folder / f"reports/anchors/{scene}.json",
            claims=REPOSITORY / "data/reference/claims.yaml",
            out=folder / f"reports/rankings/{scene}.json",
            table=folder / f"reports/rankings/{scene}.csv",
        )
    align(folder)
    (folder / "data").mkdir()
    shutil.copyfile(REPOSITORY / "data/tried.csv", folder / "data/tried.csv")


def align(folder: Path) -> None:
    """What the stage `alignment` makes of the rankings."""
    alignment.main(
        subjects=REPOSITORY / "data/reference/subjects.csv",
        rankings=folder / "reports/rankings",
        out=folder / "reports/alignment.json",
    )


def _write_params(folder: Path, scenes: dict, study: tuple, repeats: int) -> None:
    viewpoints = {
        key: {"scene": scene, "theta": theta, "phi": phi}
        for scene, views in scenes.items()
        for key, (theta, phi) in views.items()
    }
    tree = {
        "viewpoint": {"scene": study[0], "theta": study[1], "phi": study[2]},
        "viewpoints": viewpoints,
        "budget": "quick",
        "seed": 1,
        "heldout_share": 0.1,
        "ranking": {"confidence": 0.95, "equivalence_margin": 0.1},
        "scenes": {scene: {"frames": 50} for scene in scenes},
        "budgets": {
            "quick": {"repeats": repeats, "rollouts": {"episodes": 20}, "vae": {"epochs": 20, "batch": 128}}
        },
    }
    (folder / "params.yaml").write_text(yaml.safe_dump(tree, sort_keys=False))


def _write_anchors(folder: Path, scene: str, repeats: int) -> None:
    rows = [
        {"repeat": r, "no_op": -10.83 - r / 9, "blind": -6.59 - r / 9, "expert": -2.37 - r / 9,
         "expert_within_2cm_share": 1.0}
        for r in range(repeats)
    ]  # fmt: skip
    means = {
        f"{name}_mean": float(np.mean([row[name] for row in rows])) for name in rows[0] if name != "repeat"
    }
    write_json(
        folder / f"reports/anchors/{scene}.json",
        {"scene": scene, **means, "repeats": rows, "made_with": MADE_WITH},
    )


def _write_branch(
    folder: Path, scene: str, angles: tuple, place: int, repeats: int, rng: np.random.Generator
) -> None:
    head = {"scene": scene, "theta_deg": angles[0], "phi_deg": angles[1]}
    level = -3.2 - 0.9 * place
    returns = level + rng.normal(0, 0.25, repeats)
    rows = [{"repeat": r, "return": float(returns[r])} for r in range(repeats)]
    far = 0.02 + 0.021 * place
    write_json(
        folder / "evaluation.json",
        {**head, "return_mean": float(returns.mean()), "final_distance_m_mean": far,
         "within_2cm_share_mean": 0.61 - 0.1 * place, "within_5cm_share_mean": 0.97 - 0.1 * place,
         "repeats": rows, "made_with": MADE_WITH},
    )  # fmt: skip
    vae = {f"{name}_mean": float(rng.uniform(0.004, 0.06)) for name in PROBES}
    vae |= {f"{name}_mean": float(rng.uniform(0, 1)) for name in SHARES}
    vae |= {f"{name}_mean": float(rng.uniform(8, 40)) for name in VAE}
    write_json(folder / "vae.json", {**head, **vae, "repeats": []})
    cheap = {b.entry: float(rng.uniform(0.1, 1)) for b in BASELINES if b.stage == "geometry"}
    write_json(folder / "geometry.json", {**head, **cheap})
    nll = {"heldout_nll_mean": 12.3 + place, "heldout_nll_of_last_frame_mean": 20.6}
    write_json(folder / "mdnrnn.json", {**head, **nll, "repeats": []})
    _curve(level, repeats, rng).write_csv(folder / "controller.csv")


def _curve(level: float, repeats: int, rng: np.random.Generator) -> pl.DataFrame:
    generation = np.arange(60)
    tables = []
    for r in range(repeats):
        mean = level - 13 * np.exp(-generation / 9) - 0.8 + rng.normal(0, 0.35, 60).cumsum() / 8
        columns = {"repeat": r, "generation": generation, "frames": 3200 * (generation + 1)}
        tables.append(pl.DataFrame({**columns, "mean": mean, "best": mean + 0.7}))
    return pl.concat(tables)


def _write_pictures(folder: Path, angles: tuple) -> None:
    (folder / "view").mkdir(parents=True)
    large = _drawn(640, 480, angles, 0.3)
    large.save(folder / "view" / "view.png")
    large.crop((80, 0, 560, 480)).resize((64, 64)).save(folder / "view" / "view_64.png")
    grid = Image.new("RGB", (512, 128))
    for column in range(8):
        for row in range(2):
            grid.paste(_drawn(64, 64, angles, column / 8), (64 * column, 64 * row))
    grid.save(folder / "reconstructions.png")
    frames = [_drawn(128, 128, angles, step / 12) for step in range(12)]
    frames[0].save(folder / "clip.webp", save_all=True, append_images=frames[1:], duration=40, loop=0)


def _drawn(width: int, height: int, angles: tuple, reach: float) -> Image.Image:
    image = Image.new("RGB", (width, height), (96, 110, 128))
    pen = ImageDraw.Draw(image)
    w, h = width, height
    pen.rectangle((0, 0.78 * h, w, h), fill=(196, 180, 150))
    elbow = (0.35 * w + angles[0] / 400 * w, 0.3 * h)
    tip = (elbow[0] + 0.1 * w + reach * 0.2 * w, 0.45 * h + reach * 0.15 * h)
    pen.line([(0.3 * w, 0.8 * h), elbow, tip], fill=(238, 238, 240), width=max(2, w // 16), joint="curve")
    pen.ellipse((0.62 * w, 0.55 * h, 0.7 * w, 0.55 * h + 0.08 * w), fill=(214, 48, 42))
    return image


class _Page(HTMLParser):
    """Checks that tags balance, and collects what a page would load, its identifiers and its text."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.text = ""
        self.rows: dict[str, list[str]] = {}
        self._row = ""
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self._row = dict(attrs).get("data-view") or ""
        if tag in ("td", "th") and self._row:
            self.rows.setdefault(self._row, []).append("")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-1:]}"
        self.open.pop()
        if tag == "tr":
            self._row = ""

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "style":
            self.text += data
        if self._row and self.open[-1] != "tr":
            self.rows[self._row][-1] += data

    def values(self, name: str) -> list[str]:
        return [value for _, attribute, value in self.attributes if attribute == name]


Build = Callable[[], str]
FOLDERS = {name: Path("reports") / name for name in ("rankings", "branches", "anchors", "pictures")}
FOLDERS |= {
    "alignment": Path("reports/alignment.json"),
    "coverage": REPOSITORY / "data/reference/coverage.csv",
    "tried": Path("data/tried.csv"),
}
PAGE, TABLES = Path("reports/index.html"), Path("reports/tables")


def _build() -> str:
    report.main(**FOLDERS, out=PAGE, tables=TABLES)
    return PAGE.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of two scenes, written once."""
    folder = tmp_path_factory.mktemp("study")
    fetch = dict(list(VIEWS["fetch_reach"].items())[:3])
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
        return _build()


@pytest.fixture
def build(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Build:
    """A copy of the study as working directory; calling it runs the stage and reads the page."""
    shutil.copytree(study, tmp_path, dirs_exist_ok=True, ignore=shutil.ignore_patterns("index.html"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(tmp_path / "scratch"))
    return _build


def test_page_is_balanced_and_loads_nothing(html: str) -> None:
    page = _Page(html)
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
    page = _Page(html)
    names = page.values("id")
    assert len(names) == len(set(names))
    links = {value[1:] for value in page.values("href")} | set(re.findall(r"url\(#([^)]+)\)", html))
    assert links <= set(names)


def test_security_policy_allows_this_style_and_no_other(html: str) -> None:
    style = re.search(r"<style>(.*?)</style>", html, re.DOTALL)
    assert style is not None
    digest = base64.b64encode(hashlib.sha256(style[1].encode()).digest()).decode()
    policy = next(v for v in _Page(html).values("content") if "default-src" in v)
    assert f"style-src 'sha256-{digest}'" in policy
    assert "unsafe" not in policy


def test_table_rows_are_the_rankings_numbers(html: str, study: Path) -> None:
    rows = _Page(html).rows
    named = set()
    for scene in ("panda_2dof", "fetch_reach"):
        for key, row in read_json(study / f"reports/rankings/{scene}.json", "")["viewpoints"].items():
            named.add(key)
            cells = [cell.replace("−", "-") for cell in rows[key]]
            assert cells[0] == str(row["rank"])
            assert [cells[4], cells[6]] == [f"{row[k]:.2f}" for k in ("score_mean", "return_mean")]
            assert cells[7] == f"{row['return_low']:.2f} to {row['return_high']:.2f}"
            if row["difference_to_best"] is None:
                assert cells[8:10] == ["–", "–"]
            else:
                assert cells[8] == f"{row['difference_to_best']:.2f}"
                assert cells[9] == f"{row['difference_low']:.2f} to {row['difference_high']:.2f}"
            assert cells[10] == chance(row["best_chance"])
            assert cells[11].strip() == row["verdict"]
    assert set(rows) == named
    assert len(named) == 6


def test_plots_say_the_tables_numbers(html: str, study: Path) -> None:
    labels = [label.replace("−", "-") for label in _Page(html).values("aria-label")]
    row = read_json(study / "reports/rankings/panda_2dof.json", "")["viewpoints"]["panda_2dof-b"]
    score = f"b {row['score_mean']:.2f} ({row['score_low']:.2f} to {row['score_high']:.2f})"
    gap = f"b {row['difference_to_best']:.2f} ({row['difference_low']:.2f} to {row['difference_high']:.2f})"
    assert [sum(said in label for label in labels) for said in (score, gap)] == [1, 1]
    last = pl.read_csv(study / "reports/branches/panda_2dof/panda_2dof-b/controller.csv")
    last = last.filter(pl.col("generation") == 59)
    assert any(f"to {last['mean'].mean():.2f} m" in label and "view b" in label for label in labels)


def test_scenes_stand_in_the_order_of_params_and_one_not_ranked_is_named(build: Build) -> None:
    Path("params.yaml").write_text(
        Path("params.yaml").read_text().replace("scenes:\n", "scenes:\n  panda_1dof: {frames: 50}\n")
    )
    page = _Page(build())
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


def test_absent_pictures_are_named_with_the_stage_that_makes_them(build: Build) -> None:
    for name in ("view/view.png", "view/view_64.png", "reconstructions.png", "clip.webp"):
        Path("reports/pictures/fetch_reach-b", name).unlink()
    text = _Page(build()).text
    for stage, times in (("frames", 2), ("vae", 1), ("evaluation", 1)):
        sentence = f"picture not on this machine; dvc repro {stage}@fetch_reach-b makes it"
        assert text.count(sentence) == times


def test_branch_that_no_ranking_names_stays_out(html: str, build: Build) -> None:
    _write_pictures(Path("reports/pictures/panda_2dof-z"), (10, 10))
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


def test_viewpoints_that_experiments_tried_are_shown(html: str, build: Build) -> None:
    assert 'id="tried"' not in html
    rows = [
        (name, "panda_2dof", 45.0, phi, "quick", repeat, -2.0 - repeat, score + 0.05 * repeat)
        for name, phi, score in (("low-sun", 30.0, 0.4), ("high-sun", 60.0, 0.7))
        for repeat in range(3)
    ]
    pl.DataFrame(rows, schema=COLUMNS, orient="row").write_csv("data/tried.csv")
    page = _Page(build())
    assert page.text.index("high-sun") < page.text.index("low-sun")  # best first
    table = pl.read_csv("reports/tables/tried.csv")
    assert table["score_mean"].to_list() == pytest.approx([0.75, 0.45])
    assert interval(table["score_low"][0], table["score_high"][0]) in page.text
    assert any("(45°, 60°) 0.75; (45°, 30°) 0.45" in label for label in page.values("aria-label"))
    Path("data/tried.csv").write_text("a,b\n1,2\n")
    with pytest.raises(BelvedereError, match=r"pipeline\.reporting\.gather --out data/tried\.csv"):
        build()


def test_single_repeat_shows_no_interval(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, build: Build
) -> None:
    folder = tmp_path / "single"
    folder.mkdir()
    monkeypatch.chdir(folder)
    write_study(folder, {"panda_2dof": VIEWS["panda_2dof"]}, repeats=1)
    html = build()
    assert "One repeat tells no error" in html
    assert all(cells[5] == cells[7] == "–" for cells in _Page(html).rows.values())


def test_duplicate_is_named_and_not_ranked_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, build: Build
) -> None:
    folder = tmp_path / "twice"
    folder.mkdir()
    monkeypatch.chdir(folder)
    write_study(folder, {"panda_2dof": VIEWS["panda_2dof"]}, study=("panda_2dof", 90, 0))
    page = _Page(build())
    assert set(page.rows) == {"panda_2dof-a", "panda_2dof-b"}
    assert "same as study" in page.rows["panda_2dof-b"][1]


@pytest.mark.parametrize(
    ("path", "content", "says"),
    [
        ("rankings/panda_2dof.json", "{", "no JSON file"),
        ("rankings/panda_2dof.json", '{"scene": "panda_2dof"}', "confidence is not valid"),
        ("branches/panda_2dof/study/vae.json", None, "dvc repro vae@study"),
        ("branches/panda_2dof/study/vae.json", "{}", "dvc repro vae@study"),
        ("branches/panda_2dof/study/controller.csv", "a,b\n1,2\n", "no learning curve"),
        ("branches/panda_2dof/study/controller.csv", "repeat,generation,frames,mean,best\n", "no generation"),
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


def test_people_stand_beside_the_rankings(html: str, study: Path) -> None:
    found = read_json(study / "reports/alignment.json", "")
    label = 'aria-label="People and world model"'
    body = html.split(label, 1)[1].split("<tbody>", 1)[1].split("</tbody>", 1)[0]
    rows = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) for row in body.split("<tr>")[1:]]
    assert [row[0] for row in rows] == [trial["scene"] for trial in found["trials"]]
    for row, trial in zip(rows, found["trials"], strict=True):
        assert row[8].replace("−", "-") == ("–" if trial["ours"] is None else f"{trial['ours']:.2f}")
        assert row[10] == {None: "–", True: "yes", False: "no"}[trial["same_sign"]]
    assert {trial["scene"] for trial in found["trials"] if trial["ours"] is not None} == {"panda_2dof"}


def test_baselines_are_the_rankings(html: str, study: Path) -> None:
    for scene in ("panda_2dof", "fetch_reach"):
        ranked = read_json(study / f"reports/rankings/{scene}.json", "")
        body = (
            html.split(f'aria-label="Baselines of {scene}"', 1)[1]
            .split("<tbody>", 1)[1]
            .split("</tbody>", 1)[0]
        )
        rows = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) for row in body.split("<tr>")[1:]]
        order = sorted(ranked["viewpoints"], key=lambda key: ranked["viewpoints"][key]["rank"])
        assert len(rows) == len(ranked["baselines"]) == len(BASELINES)
        for row, found in zip(rows, ranked["baselines"], strict=True):
            assert row[1 : 1 + len(order)] == [f"{found['values'][key]:.3g}" for key in order]
            assert row[1 + len(order)].replace("−", "-") == f"{found['tau']:.2f}"


def test_every_table_has_its_twins(html: str, study: Path) -> None:
    """Unrounded, the same numbers as on the page; the ranking's are those of the ranking stage."""
    names = {path.stem for path in (study / TABLES).iterdir()}
    expected = "ranking pairs anchors world_models baselines effects claims people agreements"
    assert names == set(expected.split())
    for name in names:
        rows = json.loads((study / TABLES / f"{name}.json").read_text(encoding="utf-8"))
        table = pl.read_csv(study / TABLES / f"{name}.csv", infer_schema_length=None)
        assert table.columns == list(rows[0]) and table.height == len(rows)
    for row in json.loads((study / TABLES / "ranking.json").read_text()):
        ranked = read_json(study / f"reports/rankings/{row['scene']}.json", "")["viewpoints"][row["view"]]
        assert {key: row[key] for key in ranked if key != "duplicates"} == {
            key: value for key, value in ranked.items() if key != "duplicates"
        }
        assert f"<td>{row['rank']}</td>" in html
