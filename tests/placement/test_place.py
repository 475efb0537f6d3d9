"""`python -m pipeline.placement`: the file of candidates, and what stays when the declaration changes."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import yaml

from pipeline.contract.errors import BelvedereError
from pipeline.placement.__main__ import main
from pipeline.storage.candidates import (
    CANDIDATES_FILE,
    candidates_of,
    read_placed,
    ruled_out,
    searched_viewpoints,
)

REPOSITORY = Path(__file__).parents[2]
SCENE = "panda_2dof"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(REPOSITORY / "params.yaml", "params.yaml")
    declare(candidates=6)


def declare(**changes: object) -> None:
    tree = yaml.safe_load(Path("params.yaml").read_text(encoding="utf-8"))
    tree["searches"][SCENE]["placement"].update(changes)
    Path("params.yaml").write_text(yaml.safe_dump(tree, sort_keys=False), encoding="utf-8")


def test_it_writes_as_many_as_declared_each_with_a_name(capsys: pytest.CaptureFixture[str]) -> None:
    main(scene=SCENE)
    assert list(searched_viewpoints()) == [f"{SCENE}-c{n:02}" for n in range(1, 7)]
    assert "6 candidates, 0 places ruled out" in capsys.readouterr().out


def test_a_second_time_changes_no_byte() -> None:
    main(scene=SCENE)
    before = CANDIDATES_FILE.read_bytes()
    main(scene=SCENE)
    assert CANDIDATES_FILE.read_bytes() == before


def test_more_candidates_keep_the_names_of_the_earlier_ones() -> None:
    main(scene=SCENE)
    before = searched_viewpoints()
    declare(candidates=9)
    main(scene=SCENE)
    after = searched_viewpoints()
    assert len(after) == 9 and before.items() <= after.items()


def test_fewer_candidates_are_the_first_of_them() -> None:
    main(scene=SCENE)
    before = searched_viewpoints()
    declare(candidates=4)
    main(scene=SCENE)
    assert list(searched_viewpoints().items()) == list(before.items())[:4]


def test_ranges_of_distance_and_field_of_view_give_each_candidate_its_camera() -> None:
    main(scene=SCENE)
    before = candidates_of(SCENE)
    declare(distance_m=[1.2, 2.2], fov_deg=[35, 50])
    main(scene=SCENE)
    after = candidates_of(SCENE)
    assert list(after) == list(before) and len({one.distance_m for one in after.values()}) > 1
    assert all(1.2 <= one.distance_m <= 2.2 and 35 <= one.fov_deg <= 50 for one in after.values())


def test_what_is_forbidden_later_is_replaced() -> None:
    main(scene=SCENE)
    before = searched_viewpoints()
    declare(theta_deg=[0, 90])
    main(scene=SCENE)
    after = searched_viewpoints()
    assert len(after) == 6 and all(0 <= view.theta <= 90 for view in after.values())
    kept = {key for key, view in before.items() if 0 <= view.theta <= 90}
    assert kept and all(after[key] == before[key] for key in kept)


def test_walls_are_named_where_they_rule_places_out() -> None:
    wall = {"name": "the rack", "center_m": [1.3, 0.6, 0.3], "half_size_m": [0.5, 0.4, 1.0]}
    declare(forbidden=[wall])
    main(scene=SCENE)
    assert {one["why"] for one in ruled_out(SCENE)} <= {
        "the camera would stand in the rack",
        "the rack stands between the camera and a target",
    }
    assert ruled_out(SCENE) and len(searched_viewpoints()) == 6


def test_where_nothing_is_left_it_says_why_and_writes_nothing() -> None:
    everywhere = {"name": "the room", "center_m": [0, 0, 0], "half_size_m": [5, 5, 5]}
    declare(forbidden=[everywhere])
    with pytest.raises(BelvedereError, match=r"leaves 0 place.*in the room.*searches.panda_2dof.placement"):
        main(scene=SCENE)
    assert not CANDIDATES_FILE.exists()


def test_other_scenes_candidates_stay() -> None:
    main(scene=SCENE)
    text = CANDIDATES_FILE.read_text().replace(
        "candidates:\n", "candidates:\n  o-c01: {scene: o, theta: 1, phi: 2, distance_m: 1, fov_deg: 40}\n"
    )
    CANDIDATES_FILE.write_text(text)
    declare(candidates=7)
    main(scene=SCENE)
    assert searched_viewpoints()["o-c01"].theta == 1 and len(searched_viewpoints()) == 8


def test_a_scene_without_a_search_is_told() -> None:
    with pytest.raises(BelvedereError, match="panda_9dof"):
        main(scene="panda_9dof")


def test_a_file_that_is_none_is_told() -> None:
    CANDIDATES_FILE.parent.mkdir()
    CANDIDATES_FILE.write_text("candidates: {x: {scene: panda_2dof, theta: north, phi: 0}}\nruled_out: {}\n")
    with pytest.raises(BelvedereError, match=r"candidates\.x\.theta = 'north'"):
        read_placed()
