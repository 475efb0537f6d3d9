"""The ranking stage on written results: what it reads, writes and refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
import yaml
from scipy import stats

from pipeline import ranking
from pipeline.contract.errors import BelvedereError
from pipeline.stats.baselines import BASELINES
from pipeline.stats.reading import MIX_VARIABLE

PROVENANCE = {
    "device": "cpu", "dtype": "bfloat16", "threads": 2, "python": "3.11.7", "torch": "2.13.0",
    "mujoco": "3.17.0", "mujoco_warp": "3.17.0", "machine": "x86_64",
}  # fmt: skip
CLAIMS = Path(__file__).resolve().parents[2] / "data/reference/claims.yaml"
VIEWS = {"reach-a": (0, 0), "reach-b": (90, 0), "study": (45, 15)}
PROBES = {
    f"{kind}_{what}_m": error
    for kind, error in (("probe_mlp", 0.02), ("guess", 0.2))
    for what in ("tip", "target", "tip_to_target")
}
RETURNS = {"reach-a": (-2.0, -2.1, -1.8), "reach-b": (-4.0, -4.2, -3.9), "study": (-5.1, -5.0, -4.9)}


class Written:
    """A working directory with params.yaml and a scene's results, open to damage."""

    def __init__(self) -> None:
        self.params: dict[str, Any] = {
            "ranking": {
                "confidence": 0.95,
                "tolerance": 0.05,
                "equivalence_margin": 0.1,
                "scenes": {"other": {"tolerance": 0.5}},
            },
            "sight_share": 0.5,
            "budget": "few",
            "budgets": {"few": {"race": {"first": 3, "most": 20}}},
            "viewpoints": {},
        }
        for key, returns in RETURNS.items():
            self.branch(key, returns, *VIEWS[key])
        self.params["viewpoints"]["other-a"] = {"scene": "other", "theta": 0, "phi": 0}
        self.write_params()
        rows = [{"repeat": r, "no_op": -9.0, "blind": -6.0 - r, "expert": -1.0} for r in range(3)]
        self.write("anchors.json", {"scene": "reach", "repeats": rows, "provenance": PROVENANCE})

    def branch(self, key: str, returns: tuple[float, ...], theta: float, phi: float) -> None:
        place = {"scene": "reach", "theta": theta, "phi": phi}
        self.params.update(viewpoint=place) if key == "study" else self.params["viewpoints"].update(
            {key: place}
        )
        repeats = [{"repeat": r, "return": value} for r, value in enumerate(returns)]
        view = {"scene": "reach", "theta_deg": float(theta), "phi_deg": float(phi)}
        self.write(f"branches/{key}/evaluation.json", {**view, "repeats": repeats, "provenance": PROVENANCE})
        for stage in ("geometry", "operator", "vae"):
            numbers = {b.entry: abs(theta - phi) + 1.0 for b in BASELINES if b.stage == stage}
            probes = [{"repeat": r, **PROBES} for r in range(len(returns))]
            self.write(f"branches/{key}/{stage}.json", {**view, **numbers, "repeats": probes})

    def write_params(self) -> None:
        Path("params.yaml").write_text(yaml.safe_dump(self.params, sort_keys=False))
        self.repeat_over(["study", *(self.params["viewpoints"] or {})])

    def repeat_over(self, keys: list[str]) -> None:
        places = {key: "${viewpoint}" if key == "study" else f"${{viewpoints.{key}}}" for key in keys}
        Path("dvc.yaml").write_text(yaml.safe_dump({"stages": {"evaluation": {"foreach": places}}}))

    def write(self, name: str, content: object) -> None:
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(json.dumps(content))

    def edit(self, name: str, change: Callable[[dict[str, Any]], object]) -> None:
        content = json.loads(Path(name).read_text())
        change(content)
        self.write(name, content)

    def rank(self) -> dict[str, Any]:
        ranking.main(
            scene="reach", branches=Path("branches"), anchors=Path("anchors.json"), claims=CLAIMS,
            out=Path("out/reach.json"), table=Path("out/reach.csv"),
        )  # fmt: skip
        return json.loads(Path("out/reach.json").read_text())


@pytest.fixture
def written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Written:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(MIX_VARIABLE, raising=False)
    return Written()


def test_json_and_csv_say_the_same(written: Written, capsys: pytest.CaptureFixture[str]) -> None:
    content = written.rank()
    answer = content["answer"]
    assert capsys.readouterr().out == f"{answer['progress']}\nreach: {answer['sentence']}\n"
    assert (answer["kind"], answer["keys"]) == ("alone", ["reach-a"])
    assert content["race"]["open"] is False and content["race"]["out"] == {"reach-b": 3, "study": 3}
    assert content["anchors"] == pytest.approx({"no_op": -9.0, "blind": -7.0, "expert": -1.0})
    assert (content["blind_m"], content["unit_m"]) == (pytest.approx(-7.0), pytest.approx(6.0))
    rows = pl.read_csv("out/reach.csv").to_dicts()
    assert [row["branch"] for row in rows] == list(content["viewpoints"]) == list(RETURNS)
    for row in rows:
        shown = content["viewpoints"][row.pop("branch")]
        assert row.pop("scene") == "reach"
        for name in ("duplicates", "misses"):
            assert row.pop(name) in ("", None) and shown.pop(name) == []
        assert row == shown


def test_scores_have_one_unit_for_all_repeats(written: Written) -> None:
    """Each repeat's blind anchor differs; the score is of their mean."""
    view = written.rank()["viewpoints"]["reach-b"]
    expected = (np.array(RETURNS["reach-b"]) + 7.0) / 6.0
    assert view["score_mean"] == pytest.approx(expected.mean())
    interval = stats.ttest_1samp(expected, 0).confidence_interval(0.95)
    assert (view["score_low"], view["score_high"]) == pytest.approx((interval.low, interval.high))


def test_repeats_may_be_ragged(written: Written, capsys: pytest.CaptureFixture[str]) -> None:
    written.branch("reach-a", (-2.0, -2.1, -1.8, -2.2), *VIEWS["reach-a"])
    written.branch("reach-b", (-2.1, -2.1, -1.7, -2.2), *VIEWS["reach-b"])
    written.params["ranking"]["tolerance"] = 0.001
    written.write_params()
    content = written.rank()
    race = content["race"]
    assert (race["open"], race["common"], race["out"]) == (True, 4, {"study": 3})
    assert [look["repeats"] for look in race["looks"]] == [3, 4]
    assert {key: view["repeats"] for key, view in content["viewpoints"].items()} == {
        "reach-a": 4, "reach-b": 4, "study": 3,
    }  # fmt: skip
    assert {(p["first"], p["second"]): p["repeats"] for p in content["pairs"]} == {
        ("reach-a", "reach-b"): 4, ("reach-a", "study"): 3, ("reach-b", "study"): 3,
    }  # fmt: skip
    assert content["answer"]["kind"] == "open"
    assert capsys.readouterr().out == f"{content['answer']['progress']}\n"


def test_a_scenes_own_tolerance_counts(written: Written) -> None:
    assert written.rank()["tolerance"] == 0.05
    written.params["ranking"]["scenes"]["reach"] = {"tolerance": 0.7}
    written.write_params()
    assert written.rank()["tolerance"] == 0.7


def test_a_view_at_which_the_judge_cannot_see_is_not_raced(written: Written) -> None:
    dark = {"probe_mlp_tip_to_target_m": 0.15, "probe_mlp_tip_m": 0.15}
    written.edit("branches/reach-a/vae.json", lambda c: [row.update(dark) for row in c["repeats"]])
    content = written.rank()
    view = content["viewpoints"]["reach-a"]
    assert (view["state"], view["misses"], view["behind_leader"]) == ("cannot see", ["tip"], None)
    assert (view["probe_m"], view["guess_m"]) == (pytest.approx(0.15), pytest.approx(0.2))
    assert content["answer"]["keys"] == ["reach-b"]
    assert all("reach-a" not in baseline["values"] for baseline in content["baselines"])
    for key in VIEWS:
        written.edit(f"branches/{key}/vae.json", lambda c: [row.update(dark) for row in c["repeats"]])
    content = written.rank()
    assert (content["answer"]["kind"], content["race"]["open"]) == ("cannot see", False)
    assert content["baselines"] == []
    assert pl.read_csv("out/reach.csv")["misses"].to_list() == ["tip"] * 3


def test_the_same_results_give_the_same_bytes(written: Written) -> None:
    written.rank()
    before = [Path(f"out/reach.{kind}").read_bytes() for kind in ("json", "csv")]
    written.rank()
    assert before == [Path(f"out/reach.{kind}").read_bytes() for kind in ("json", "csv")]


@pytest.mark.parametrize("theta_deg", [90.0, -270.0])
def test_a_viewpoint_named_twice_is_ranked_once(written: Written, theta_deg: float) -> None:
    before = written.rank()
    written.branch("study", RETURNS["reach-b"], theta_deg, -0.0)
    written.branch("reach-z", RETURNS["study"], 45, 15)
    written.write_params()
    content = written.rank()
    assert set(content["viewpoints"]) == {"reach-a", "reach-b", "reach-z"}
    assert content["viewpoints"]["reach-b"]["duplicates"] == ["study"]
    assert content["viewpoints"]["reach-z"].pop("score_low") == before["viewpoints"]["study"]["score_low"]
    assert pl.read_csv("out/reach.csv")["duplicates"].to_list() == ["", "study", ""]


def test_a_removed_viewpoint_disappears_though_its_file_stays(written: Written) -> None:
    del written.params["viewpoints"]["reach-b"]
    written.write_params()
    assert set(written.rank()["viewpoints"]) == {"reach-a", "study"}


@pytest.mark.parametrize("key", ["reach-b", "other-a"])
def test_a_viewpoint_that_nothing_computes_is_not_ranked_from_its_last_result(
    written: Written, key: str
) -> None:
    written.repeat_over([other for other in ("study", *written.params["viewpoints"]) if other != key])
    with pytest.raises(BelvedereError, match=f"the viewpoint '{key}', but stage 'evaluation' of dvc.yaml"):
        written.rank()
    assert not Path("out").exists()


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("ranking", "confidence"), 0.9, r"ranking\.confidence = 0\.9 is not valid: .* known for 0\.95 only"),
        (("budgets", "few", "race", "first"), 2, r"it has 3 repeats, but the budget's race\.first is 2"),
        (("budgets", "few", "race", "first"), 1, "greater than or equal to 2"),
        (("budgets", "few", "race", "most"), 41, "less than or equal to 40"),
    ],
)
def test_parameters_without_a_meaning_are_refused(
    written: Written, place: tuple[str, ...], value: float, message: str
) -> None:
    node = written.params
    for key in place[:-1]:
        node = node[key]
    node[place[-1]] = value
    written.write_params()
    with pytest.raises(BelvedereError, match=message):
        written.rank()


@pytest.mark.parametrize("name", ["device", "dtype", "torch", "mujoco", "mujoco_warp"])
def test_branches_made_differently_are_refused_unless_allowed(
    written: Written, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    written.edit(
        "branches/study/evaluation.json", lambda content: content["provenance"].update({name: "new"})
    )
    with pytest.raises(
        BelvedereError, match=rf"made differently: {name} is 'new' for study.*BELVEDERE_MIX"
    ) as refused:
        written.rank()
    choice = f"BELVEDERE_{name.upper()}={PROVENANCE[name]} " if name in ("device", "dtype") else ""
    assert f"(`{choice}dvc repro`)" in str(refused.value)
    assert not Path("out").exists()
    monkeypatch.setenv(MIX_VARIABLE, "allow")
    assert written.rank()["provenance"][name] == f"{PROVENANCE[name]} | new"
    monkeypatch.setenv(MIX_VARIABLE, "yes")
    with pytest.raises(BelvedereError, match="'yes' is unknown; available: allow"):
        written.rank()


def test_unlike_gpus_are_refused(written: Written) -> None:
    written.edit("branches/study/evaluation.json", lambda content: content["provenance"].update(gpu="H100"))
    with pytest.raises(BelvedereError, match="gpu is 'H100' for study but None for reach-a"):
        written.rank()


def test_threads_and_machine_may_differ(written: Written) -> None:
    elsewhere = {"threads": 64, "machine": "aarch64", "python": "3.12.1"}
    written.edit("branches/study/evaluation.json", lambda content: content["provenance"].update(elsewhere))
    assert written.rank()["answer"]["kind"] == "alone"


def test_anchors_of_another_physics_are_refused(written: Written) -> None:
    written.edit("anchors.json", lambda content: content["provenance"].update(device="gpu", mujoco="4.0.0"))
    with pytest.raises(BelvedereError, match=r"mujoco is '4\.0\.0' for anchors"):
        written.rank()


STUDY = "branches/study/evaluation.json"
BAD: dict[str, tuple[str, Callable[[dict[str, Any]], object], str]] = {
    "fewer repeats": (
        STUDY,
        lambda c: c["repeats"].pop(),
        "study has 2 repeats, but a view is compared from 3",
    ),
    "other repeats": (STUDY, lambda c: c["repeats"][0].update(repeat=7), r"are \[1, 2, 7\], not 0 to 2"),
    "fewer anchors": (
        "anchors.json",
        lambda c: c["repeats"].pop(),
        r"has 2 repeats, but the budget's race\.first",
    ),
    "a repeat twice": (STUDY, lambda c: c["repeats"][0].update(repeat=1), "not distinct"),
    "no repeats": (STUDY, lambda c: c.update(repeats=[]), "repeats are none"),
    "no return": (STUDY, lambda c: c["repeats"][1].pop("return"), "lack a number"),
    "NaN": (STUDY, lambda c: c["repeats"][1].update({"return": float("nan")}), "not finite"),
    "another view": (STUDY, lambda c: c.update(phi_deg=30.0), r"evaluation\.json cannot be used.*30\.0"),
    "no provenance": (STUDY, lambda c: c.pop("provenance"), "made with"),
    "another scene": ("anchors.json", lambda c: c.update(scene="other"), "of scene 'other', not 'reach'"),
    "expert blind": ("anchors.json", lambda c: c["repeats"][2].update(expert=-8.0), "in repeat 2 the expert"),
}


@pytest.mark.parametrize("stage", ["geometry", "operator", "vae", "dqn"])
def test_what_stands_beside_the_returns_is_of_the_same_viewpoint(written: Written, stage: str) -> None:
    file = f"branches/study/{stage}.json"
    content = json.loads(Path(file).read_text()) if stage != "dqn" else {"repeats": []}
    written.write(file, content | {"scene": "reach", "theta_deg": 45.0, "phi_deg": 30.0})
    with pytest.raises(
        BelvedereError, match=rf"{stage}\.json cannot be used.*30\.0.*dvc repro {stage}@study"
    ):
        written.rank()
    written.write(file, content | {"scene": "reach", "theta_deg": 45.0, "phi_deg": 15.0})
    assert written.rank()["answer"]["kind"] == "alone"


@pytest.mark.parametrize("case", BAD)
def test_bad_results_are_refused_in_a_sentence(written: Written, case: str) -> None:
    name, change, message = BAD[case]
    written.edit(name, change)
    with pytest.raises(BelvedereError, match=message):
        written.rank()
    assert not Path("out").exists()


def test_missing_results_name_the_stage_that_makes_them(written: Written) -> None:
    Path(STUDY).unlink()
    with pytest.raises(BelvedereError, match=r"evaluation\.json is missing; `dvc repro evaluation@study`"):
        written.rank()
    Path("anchors.json").unlink()
    written.branch("study", RETURNS["study"], *VIEWS["study"])
    with pytest.raises(BelvedereError, match="`dvc repro anchors@reach`"):
        written.rank()


def test_a_scene_without_viewpoints_is_refused(written: Written) -> None:
    written.params.update(viewpoints=None, viewpoint={"scene": "other", "theta": 0, "phi": 0})
    written.write_params()
    with pytest.raises(BelvedereError, match="'reach' is unknown; available: other"):
        written.rank()
