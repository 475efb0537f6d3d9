"""Every value of params.yaml that is not valid is told in one sentence, before anything is run or deleted."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pipeline.checks import parameters
from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.yamls import read_yaml
from tests.support import ROOT, Clone

Place = tuple[Any, ...]
TREE = read_yaml(ROOT / params.PARAMS_FILE)
NOWHERE: list[Any] = [["a"], {}, {"a": 1}]
NO_NUMBERS = [*NOWHERE, None, "abc", "1", True, float("nan"), float("inf"), 10**30, -(10**30)]
NO_NAMES = [
    *NOWHERE,
    None,
    5,
    1.5,
    True,
    "no such name",
    "../../x",
    "a b",
    '"><img src=x onerror=y>',
    "a; touch x",
]
NO_TRUTHS = [*NOWHERE, None, "abc", 1]
MAY_BE_NULL = ("above_target_m", "desk", "most_trainings")
MAY_BE_THE_SCENES = ("distance_m", "fov_deg")  # below placement
MAY_BE_ANY_TEXT = "about"
HAVE_DEFAULTS = ("home", "offset_m", "largest_step")  # of a robot; the other keys of params.yaml have none
CHOSEN = (
    (),
    ("viewpoints",),
    ("robots",),
    ("scenes",),
    ("budgets",),
    ("searches",),
)  # below these stand names that a user chooses


def values(tree: Any, place: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Each value that is neither mapping nor list, and where it stands."""
    if isinstance(tree, (dict, list)):
        for key, own in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from values(own, (*place, key))
    else:
        yield place, tree


def mappings(tree: Any, place: Place = ()) -> Iterator[tuple[Place, dict[Any, Any]]]:
    if isinstance(tree, dict):
        yield place, tree
    if isinstance(tree, (dict, list)):
        for key, own in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from mappings(own, (*place, key))


def changed(place: Place, value: Any) -> dict[str, Any]:
    tree = copy.deepcopy(TREE)
    node = tree
    for key in place[:-1]:
        node = node[key]
    node[place[-1]] = value
    return tree


def without(place: Place) -> dict[str, Any]:
    tree = copy.deepcopy(TREE)
    node = tree
    for key in place[:-1]:
        node = node[key]
    del node[place[-1]]
    return tree


def told(tree: Any, folder: Path) -> str:
    """What is said of a tree of parameters; nothing if it is valid."""
    path = folder / "params.yaml"
    path.write_text(json.dumps(tree), encoding="utf-8")
    params._tree.cache_clear()
    try:
        parameters.check(path)
    except BelvedereError as error:
        said = str(error)
        assert "\n" not in said and said.endswith(".") and len(said) < len(str(path)) + 400, said
        return said
    return ""


def bad(place: Place, value: Any) -> list[Any]:
    if isinstance(value, bool):
        return NO_TRUTHS
    if place[-1] in MAY_BE_NULL or ("placement" in place and place[-1] in MAY_BE_THE_SCENES):
        return [v for v in NO_NUMBERS if v is not None]
    if isinstance(value, (int, float)):
        return NO_NUMBERS
    return [v for v in NO_NAMES if not (place[-1] == MAY_BE_ANY_TEXT and isinstance(v, str))]


def test_what_the_house_ships_is_valid(tmp_path: Path) -> None:
    assert told(TREE, tmp_path) == ""


def fields() -> list[tuple[Place, Any]]:
    """Each value of a kind once: not every scene's, budget's and viewpoint's, nor every number of a list."""
    found: dict[Place, tuple[Place, Any]] = {}
    for place, value in values(TREE):
        kind = tuple("*" if place[:i] in CHOSEN[1:] or isinstance(k, int) else k for i, k in enumerate(place))
        found.setdefault(kind, (place, value))
    return list(found.values())


def test_no_value_of_another_kind_or_range_passes(tmp_path: Path) -> None:
    cases = [(place, other) for place, value in fields() for other in bad(place, value)]
    print(f"{len(cases)} cases of {len(fields())} parameters")
    passed = [case for case in cases if not told(changed(*case), tmp_path)]
    assert not passed
    assert len(cases) > 9 * len(fields()) > 700


def test_no_key_may_be_added_or_lacking(tmp_path: Path) -> None:
    tried = 0
    for place, mapping in mappings(TREE):
        if place in CHOSEN[1:]:
            continue
        assert "nonsense" in told(changed((*place, "nonsense"), 1), tmp_path), place
        overlay = "scenes" in place[1:-1] or place[-1:] == (
            "scenes",
        )  # a scene's own sizes, of which all may go
        for key in () if overlay or place[-1:] == ("home",) else mapping:
            if place[:1] == ("robots",) and key in HAVE_DEFAULTS:
                continue
            tried += 1
            assert (key == "scenes" and place) or told(without((*place, key)), tmp_path), (place, key)
    print(f"{tried} keys")
    assert tried > 200


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (("budget", "nope"), "budget"),
        (("viewpoint", {"scene": "panda_1dof", "theta": 0, "phi": 90}), "viewpoint.phi = 90"),
        (("viewpoints", {"study": TREE["viewpoint"]}), "below viewpoints = 'study'"),
        (("viewpoints", {"../../x": TREE["viewpoint"]}), "below viewpoints = '../../x'"),
        (("viewpoints", {"a": TREE["viewpoint"] | {"scene": "nope"}}), "scene of viewpoint a"),
        (
            ("viewpoints", {"a": TREE["viewpoint"] | {"theta": "90; touch x #"}}),
            "viewpoints.a.theta = '90; touch x #'",
        ),
        (("scenes", {**TREE["scenes"], "a b": TREE["scenes"]["panda_1dof"]}), "below scenes = 'a b'"),
        (("ranking", {**TREE["ranking"], "scenes": {"nope": {"tolerance": 0.1}}}), "'nope'"),
    ],
)
def test_names_and_what_they_refer_to(change: tuple[str, Any], part: str, tmp_path: Path) -> None:
    assert part in told(changed((change[0],), change[1]), tmp_path)


def test_a_stride_within_an_episode_only(tmp_path: Path) -> None:
    place = ("budgets", "tiny", "vae", "frame_stride")
    frames = TREE["scenes"]["panda_1dof"]["frames"]
    assert told(changed(place, frames), tmp_path) == ""
    assert f"has {frames} frames" in told(changed(place, frames + 1), tmp_path)


def test_a_scene_that_is_refused_is_not_printed(tmp_path: Path) -> None:
    said = told(changed(("scenes", "panda_2dof", "target", "jitter_m"), [0, 0.5, 0]), tmp_path)
    assert "scenes.panda_2dof is not valid: target candidate" in said and "substeps" not in said


NO_TEXTS = {
    "latin-1": "# Grün\nbudget: quick\n".encode("latin-1"),
    "utf-16": (ROOT / params.PARAMS_FILE).read_text(encoding="utf-8").encode("utf-16"),
    "empty": b"",
    "list": b"- a\n",
    "twice": (ROOT / params.PARAMS_FILE).read_bytes() + b"seed: 2\n",
    "code": b"budget: !!python/object/apply:os.system [touch x]\n",
    "nested": b"a: " + b"[" * 5000 + b"]" * 5000,
    "digits": b"seed: " + b"9" * 5000 + b"\n",
    "no such budget": (ROOT / params.PARAMS_FILE).read_bytes().replace(b"budget: quick", b"budget: huge"),
}


@pytest.mark.parametrize("command", ["runner", "runner.dvc repro -s rollouts@panda_1dof"])
def test_every_door_tells_it_and_deletes_nothing(clone: Clone, command: str) -> None:
    out = clone.root / "data/rollouts/panda_1dof.zarr/kept"
    out.parent.mkdir(parents=True)
    out.touch()
    for name, text in NO_TEXTS.items():
        (clone.root / params.PARAMS_FILE).write_bytes(text)
        done = clone.run("python", "-m", *command.split(), status=None)
        lines = [line for line in done.stderr.splitlines() if line.lower().startswith("error: ")]
        assert done.returncode and len(lines) == 1, (name, done.stderr)
        assert "Traceback" not in done.stderr and str(params.PARAMS_FILE) in done.stderr, name
        assert out.is_file() and not (clone.root / "x").exists(), name
