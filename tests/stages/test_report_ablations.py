"""The page's section on ablations: scores, changes, the order of the views, and the table for others."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.reporting.ablations import read_ablations
from tests.stages.report_page import TABLES, Page, build, rows
from tests.stages.report_study import VIEWS, write_study

SCENE = "panda_2dof"
VARIANTS = ("z alone", "dream")


def write(key: str, whole: float, **changes: float) -> None:
    variants: dict[str, Any] = {"whole": {"scores": [whole, whole], "score": whole}}
    for name, change in changes.items():
        score = whole + change
        numbers = {"score": score, "change": change, "low": change - 0.02, "high": change + 0.02}
        variants[name.replace("_", " ")] = {"scores": [score, score], **numbers}
    angles = {"scene": SCENE, "theta_deg": 0.0, "phi_deg": 30.0, "budget": "quick", "seed": 1}
    file = Path("reports/ablations") / SCENE / f"{key}.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps({**angles, "repeats": 2, "variants": variants}))


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    folder = tmp_path_factory.mktemp("study")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("BELVEDERE_SCRATCH", str(folder / "scratch"))
        write_study(folder, {SCENE: VIEWS[SCENE]})
        assert 'id="ablations"' not in build()
        write(f"{SCENE}-a", 0.8, z_alone=-0.01, dream=-0.3)
        write(f"{SCENE}-b", 0.9, z_alone=-0.2, dream=-0.35)
        return build(), folder


def test_views_stand_by_the_whole_judge_s_score_with_their_changes(page: tuple[str, Path]) -> None:
    found = rows(page[0], f"Ablations in {SCENE}")
    assert [row[0] for row in found] == ["b", "a"]
    assert found[0][2:6] == ["0.90", "0.70", "−0.20", "−0.22 to −0.18"]
    assert found[1][6:8] == ["0.50", "−0.30"]
    assert "#ablations" in Page(page[0]).values("href")


def test_how_each_variant_orders_the_views_is_said(page: tuple[str, Path]) -> None:
    text = " ".join(Page(page[0]).text.split())
    assert "whole b, a; z alone a, b; dream b, a" in text


def test_the_table_is_there_for_others(page: tuple[str, Path]) -> None:
    table = json.loads((page[1] / TABLES / "ablations.json").read_text())
    assert {(row["view"], row["variant"]) for row in table} == {
        (f"{SCENE}-{key}", name) for key in "ab" for name in ("whole", *VARIANTS)
    }


def test_a_foreign_table_is_told(tmp_path: Path) -> None:
    (tmp_path / SCENE).mkdir()
    (tmp_path / SCENE / "x.json").write_text('{"repeats": 2}')
    with pytest.raises(BelvedereError, match=r"x.json: theta_deg is not valid.*ablation/dvc.yaml:ablation@x"):
        read_ablations(tmp_path)
