"""dvc.yaml against the code: what a stage imports, reads and takes is what dvc.yaml says of it.

A dependency that is not listed leaves stale results; one that is listed and not used recomputes for nothing.
"""

from __future__ import annotations

import argparse
import importlib
import re
import shlex
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.contract.source import ROOT, modules_behind
from pipeline.storage.stage import parser
from tests.source import params_read_by

PARAMS: dict[str, Any] = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
ROOT_STAGES: dict[str, Any] = yaml.safe_load((ROOT / "dvc.yaml").read_text(encoding="utf-8"))["stages"]
SEARCH: dict[str, Any] = yaml.safe_load((ROOT / "search/dvc.yaml").read_text(encoding="utf-8"))
ABLATION: dict[str, Any] = yaml.safe_load((ROOT / "ablation/dvc.yaml").read_text(encoding="utf-8"))
STAGES = {
    **ROOT_STAGES,
    **{name: SEARCH["stages"][name] for name in ("search", "mounting")},
    **ABLATION["stages"],
}
ASIDE = ("search/", "ablation/")
IN_GIT = ("reports/", "search/found/", "search/mounting/", "ablation/found/")
CAMERA_FLAGS = " --distance=${item.distance_m} --fov=${item.fov_deg}"
OF_CANDIDATES = sorted(SEARCH["stages"].keys() - {"search", "mounting"})
PER_SCENE = ("ranking", "scene", "rollouts", "anchors")
ONCE = ("report", "people", "trials")
SCENE_FILES = {"data/scenes/${key}.json", "data/scenes/${item.scene}.json"}  # deps that need no flag

each_stage = pytest.mark.parametrize("stage", STAGES)


def form(stage: str) -> dict[str, Any]:
    """A stage's declaration, with its templates as they stand."""
    return STAGES[stage].get("do", STAGES[stage])


def paths(stage: str, *kinds: str) -> list[str]:
    """The paths listed under ``kinds`` (deps, outs, metrics, plots)."""
    entries = [entry for kind in kinds for entry in form(stage).get(kind, [])]
    return [entry if isinstance(entry, str) else next(iter(entry)) for entry in entries]


def code_deps(stage: str) -> set[str]:
    return {path for path in paths(stage, "deps") if path.startswith("pipeline/")}


def flags(stage: str) -> dict[str, str]:
    """The flags in a stage's command and their values."""
    words = re.sub(r"\$\{[^}]*\}", lambda match: match[0].replace(" ", ""), form(stage)["cmd"]).split()
    words = [part for word in words[3:] for part in word.split("=", 1)]
    return dict(zip(words[::2], words[1::2], strict=True))


@cache
def arguments(stage: str) -> dict[str, argparse.Action]:
    actions = parser(importlib.import_module(f"pipeline.{stage}").main)._actions
    return {action.option_strings[-1]: action for action in actions if action.dest != "help"}


def test_each_script_is_a_stage_and_each_stage_a_script() -> None:
    scripts = {path.stem for path in (ROOT / "pipeline").glob("*.py")} - {"__init__"}
    assert scripts == set(STAGES)


@each_stage
def test_a_stage_says_what_it_does(stage: str) -> None:
    assert form(stage)["desc"]


@each_stage
def test_the_command_runs_the_stage_of_that_name(stage: str) -> None:
    assert shlex.split(form(stage)["cmd"])[:3] == ["python", "-m", f"pipeline.{stage}"]


@each_stage
def test_flags_are_those_of_main(stage: str) -> None:
    known = arguments(stage)
    required = {flag for flag, action in known.items() if action.required}
    assert required <= set(flags(stage)) <= set(known)


@each_stage
def test_a_small_negative_angle_is_passed_as_a_number(stage: str) -> None:
    """YAML writes it as -1e-05, which after a space argparse takes for a flag."""
    angles = {name for name in ("theta", "phi") if f"--{name}" in arguments(stage)}
    command = re.sub(r"\$\{item\.(theta|phi)\}", "-1e-05", form(stage)["cmd"])
    command = re.sub(r"\$\{item\.(distance_m|fov_deg)\}", "1", command)
    words = re.sub(r"\$\{[^}]*\}", "x", command).split()[3:]
    given = vars(parser(importlib.import_module(f"pipeline.{stage}").main).parse_args(words))
    assert {name for name in given if given[name] == -1e-05} == angles


@each_stage
def test_every_path_in_the_command_is_declared_and_every_declared_path_is_in_the_command(stage: str) -> None:
    in_command = {value for flag, value in flags(stage).items() if arguments(stage)[flag].type is Path}
    declared = set(paths(stage, "deps", "outs", "metrics", "plots")) - code_deps(stage)
    assert in_command == declared - (SCENE_FILES if stage != "scene" else set())


def test_the_stages_that_compile_a_scene_depend_on_its_robots_files() -> None:
    """They read the robot's files themselves; what stage `scene` wrote says when these changed."""
    compiling = {s for s in STAGES if "robots.*" in params_read_by(f"pipeline/{s}.py")}
    assert compiling >= {"scene", "rollouts", "frames", "evaluation"}
    assert compiling - {"scene"} == {s for s in STAGES if SCENE_FILES & set(paths(s, "deps"))}
    assert "robots" in paths("scene", "deps")


@each_stage
def test_deps_cover_all_that_the_stage_imports(stage: str) -> None:
    imported = modules_behind(f"pipeline/{stage}.py")
    covered = {file for file in imported if covering(file, code_deps(stage))}
    assert imported - covered - {"pipeline/__init__.py"} == set()


@each_stage
def test_no_dep_names_code_that_the_stage_does_not_import(stage: str) -> None:
    imported = modules_behind(f"pipeline/{stage}.py")
    used = {dep for dep in code_deps(stage) if any(covering(file, {dep}) for file in imported)}
    assert code_deps(stage) == used


def covering(file: str, deps: set[str]) -> bool:
    return any(file == dep or file.startswith(f"{dep}/") for dep in deps)


def listed(stage: str) -> set[str]:
    """The parameter keys that dvc.yaml lists, whichever scene they are for."""
    entries = [key for key in form(stage).get("params", []) if isinstance(key, str)]
    return {re.sub(r"\$\{(item\.scene|key)\}", "*", key) for key in entries}


def within(key: str, outer: str) -> bool:
    """Whether ``key`` is ``outer`` or lies in it."""
    return f"{key}.".startswith(f"{outer}.")


@each_stage
def test_params_that_the_stage_reads_are_listed(stage: str) -> None:
    read = params_read_by(f"pipeline/{stage}.py")
    assert {key for key in read if not is_listed(key, stage)} == set()


def is_listed(key: str, stage: str) -> bool:
    """Whether a stage lists ``key``, or reads a table only to find in it what it lists."""
    known = listed(stage)
    if key == "robots.*" and SCENE_FILES & set(paths(stage, "deps")):
        return True  # what stage `scene` wrote holds the robot's declaration
    found_in = {"scenes": "scenes", "budgets": "budgets", "budget": "budgets"}.get(key)
    return any(within(key, k) for k in known) or any(found_in and within(k, found_in) for k in known)


@each_stage
def test_params_that_are_listed_are_read(stage: str) -> None:
    read = params_read_by(f"pipeline/{stage}.py")
    unread = {key for key in listed(stage) if not any(within(key, r) or within(r, key) for r in read)}
    assert unread == set()


@each_stage
@pytest.mark.parametrize("budget", PARAMS["budgets"])
def test_params_that_are_listed_exist_in_every_budget_and_scene(stage: str, budget: str) -> None:
    for key in listed(stage):
        for scene in PARAMS["searches" if stage == "search" else "scenes"]:
            node: Any = PARAMS
            for part in key.replace("${budget}", budget).replace("*", scene).split("."):
                assert part in node, f"{key}: {part} is not in params.yaml"
                node = node[part]


def test_a_branch_depends_on_its_own_number_of_repeats_and_episodes_on_their_scene_s() -> None:
    files = {s: [key for key in form(s).get("params", []) if isinstance(key, dict)] for s in STAGES}
    assert {stage: found for stage, found in files.items() if found} == {
        "rollouts": [{"data/allocation.yaml": ["scenes.${key}"]}],
        "frames": [{"data/allocation.yaml": ["branches.${key}"]}],
    }
    readers = {s for s in STAGES if "pipeline/storage/allocation.py" in modules_behind(f"pipeline/{s}.py")}
    assert readers == {"rollouts", "frames"}


def test_every_branch_and_scene_has_a_number_of_repeats() -> None:
    allocation = yaml.safe_load((ROOT / "data/allocation.yaml").read_text(encoding="utf-8"))
    candidates = yaml.safe_load((ROOT / "search/candidates.yaml").read_text(encoding="utf-8"))["candidates"]
    assert set(allocation["branches"]) == {"study", *PARAMS["viewpoints"], *candidates}
    assert set(allocation["scenes"]) == set(PARAMS["scenes"])


def test_the_budgets_have_the_same_sections() -> None:
    sections = {name: set(budget) for name, budget in PARAMS["budgets"].items()}
    assert len({frozenset(keys) for keys in sections.values()}) == 1, sections


@pytest.mark.parametrize("stage", PER_SCENE)
def test_a_scene_of_the_parameters_needs_no_line_here(stage: str) -> None:
    assert STAGES[stage]["foreach"] == "${scenes}"


@pytest.mark.parametrize("stage", sorted(set(ROOT_STAGES) - {*PER_SCENE, *ONCE}))
def test_branches_agree_and_study_is_first(stage: str) -> None:
    branches = {"study": "${viewpoint}"} | {key: f"${{viewpoints.{key}}}" for key in PARAMS["viewpoints"]}
    assert list(STAGES[stage]["foreach"].items()) == list(branches.items())


@pytest.mark.parametrize("stage", OF_CANDIDATES)
def test_a_candidate_s_stages_are_those_of_a_branch(stage: str) -> None:
    """But for metrics' and pictures' folders, cameras, and that one repeat suffices at first."""
    text = yaml.safe_dump(ROOT_STAGES[stage]["do"])
    for part in ("branches", "pictures"):
        text = text.replace(f"reports/{part}", f"search/{part}")
    expected = yaml.safe_load(text)
    found = dict(SEARCH["stages"][stage]["do"])
    assert SEARCH["stages"][stage]["foreach"] == "${candidates}" and found.pop("wdir") == ".."
    assert ("first" in flags(stage)) is False
    found["cmd"] = found["cmd"].replace(" --first 1", "").replace(CAMERA_FLAGS, "")
    assert found == expected


def test_candidates_go_through_all_that_a_search_looks_at() -> None:
    assert OF_CANDIDATES == ["controller", "evaluation", "frames", "latents", "mdnrnn", "vae"]
    given = {s for s in OF_CANDIDATES if " --first 1" in SEARCH["stages"][s]["do"]["cmd"]}
    assert given == {"controller", "frames"}
    seeing = {s for s in SEARCH["stages"] if CAMERA_FLAGS in SEARCH["stages"][s]["do"]["cmd"]}
    assert seeing == {"controller", "evaluation", "frames", "mounting"}
    assert SEARCH["vars"] == ["../params.yaml", "candidates.yaml", "finalists.yaml"]
    assert SEARCH["stages"]["mounting"]["foreach"] == "${finalists}"
    assert STAGES["search"]["foreach"] == "${searches}"


def test_a_search_waits_for_its_candidates_and_anchors_only() -> None:
    candidates = yaml.safe_load((ROOT / "search/candidates.yaml").read_text(encoding="utf-8"))["candidates"]
    for scene in PARAMS["searches"]:
        awaited = {
            f"search/dvc.yaml:{stage}@{key}"
            for key, view in candidates.items()
            for stage in ("vae", "mdnrnn", "controller", "evaluation")
            if view["scene"] == scene
        }
        assert graph()[f"search/dvc.yaml:search@{scene}"] == awaited | {f"anchors@{scene}"}


def test_no_stage_of_a_run_waits_for_a_candidate_or_an_ablation() -> None:
    for stage, awaited in graph().items():
        if not stage.startswith(ASIDE):
            assert not any(name.startswith(ASIDE) for name in awaited), stage


def test_viewpoints_name_scenes_and_their_keys_say_which() -> None:
    for key, viewpoint in PARAMS["viewpoints"].items():
        assert re.fullmatch(re.escape(viewpoint["scene"]) + "-[a-z]", key)
        assert viewpoint["scene"] in PARAMS["scenes"]


def test_what_goes_into_git_is_not_cached_and_all_else_is() -> None:
    for stage in STAGES:
        for entry in [*form(stage).get("metrics", []), *form(stage).get("plots", [])]:
            ((path, options),) = entry.items()
            assert options["cache"] is False and path.startswith(IN_GIT)
        assert all(isinstance(out, str) for out in form(stage).get("outs", []))


@cache
def graph() -> dict[str, set[str]]:
    """What each stage waits for directly, as DVC itself reads dvc.yaml."""
    from dvc.repo import Repo

    with Repo(str(ROOT)) as repo:
        edges = repo.index.graph
        return {stage.addressing: {s.addressing for s in edges.successors(stage)} for stage in edges}


def test_a_ranking_waits_for_the_branches_and_anchors_of_its_scene_only() -> None:
    branches = PARAMS["viewpoints"] | {"study": PARAMS["viewpoint"]}
    for scene in PARAMS["scenes"]:
        awaited = {
            f"{stage}@{key}"
            for key, viewpoint in branches.items()
            for stage in ("geometry", "operator", "vae", "mdnrnn", "controller", "evaluation", "dqn")
            if viewpoint["scene"] == scene
        }
        assert graph()[f"ranking@{scene}"] == awaited | {f"anchors@{scene}"}


def test_the_report_waits_for_every_ranking_and_picture() -> None:
    awaited = graph()["report"]
    assert {f"ranking@{scene}" for scene in PARAMS["scenes"]} <= awaited
    assert {f"{stage}@{key}" for key in PARAMS["viewpoints"] for stage in ("frames", "evaluation")} <= awaited
