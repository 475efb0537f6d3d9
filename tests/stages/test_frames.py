"""Episodes and frames grow by a repeat: what a scene's viewpoints depend on, and what is rendered, stays."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from pipeline import frames, rollouts
from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import viewpoint
from pipeline.sim.scene import load_scene
from pipeline.storage import zarrs
from pipeline.storage.allocation import Allocation, Entry, write_allocation

ROOT = Path(__file__).resolve().parents[2]
SCENE, BRANCH = "panda_2dof", "panda_2dof-a"
VIEW = {"scene": SCENE, "theta": 0.0, "phi": 0.0}
FRAMES = 3
EPISODE_BYTES = FRAMES * 64 * 64 * 3  # of pictures


@pytest.fixture
def place(workplace: Path) -> Path:
    tree = yaml.safe_load((ROOT / params.PARAMS_FILE).read_text(encoding="utf-8"))
    tree["scenes"][SCENE]["frames"] = FRAMES
    tree["budget"] = "tiny"
    (workplace / "params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")
    return workplace


def allocate(scene: int, branch: int) -> None:
    entry = Entry(**VIEW, repeats=branch)
    seed = yaml.safe_load(Path("params.yaml").read_text())["seed"]
    write_allocation(Allocation(budget="tiny", seed=seed, scenes={SCENE: scene}, branches={BRANCH: entry}))


def roll(place: Path) -> Path:
    rollouts.main(scene=SCENE, out=place / f"{SCENE}.json", store=place / SCENE)
    return place / f"{SCENE}.json"


def shoot(episodes: Path, place: Path) -> zarrs.Store:
    out = {"out": place / "frames", "picture": place / "view"}
    frames.main(branch=BRANCH, **VIEW, rollouts=episodes, **out)
    return zarrs.Store(place / "frames", zarrs.FRAMES, "frames")


def test_one_more_repeat_changes_nothing_of_the_others(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    allocate(scene=2, branch=2)
    episodes = roll(place)
    said, first = episodes.read_bytes(), zarrs.Store(place / SCENE, zarrs.ROLLOUTS, "").repeat("qpos", 1)
    assert len(json.loads(said)["first_repeats"]) == 2
    seen = shoot(episodes, place).repeat("rgb", 1)

    allocate(scene=3, branch=3)
    assert roll(place).read_bytes() == said
    store = zarrs.Store(place / SCENE, zarrs.ROLLOUTS, "")
    assert store.repeats == 3
    np.testing.assert_array_equal(store.repeat("qpos", 1), first)

    rendered = []
    render = frames.render
    monkeypatch.setattr(frames, "render", lambda *a: rendered.append(a[2]) or render(*a))
    more = shoot(episodes, place)
    assert rendered == [2] and more.repeats == 3
    np.testing.assert_array_equal(more.repeat("rgb", 1), seen)
    assert (more.repeat("rgb", 2) != seen).any()


def test_a_branch_has_its_own_number_of_repeats(place: Path) -> None:
    allocate(scene=3, branch=2)
    store = shoot(roll(place), place)
    assert store.repeats == 2
    with Image.open(place / "view" / "view_64.png") as picture:
        np.testing.assert_array_equal(np.asarray(picture), store.repeat("rgb", 0)[0, 0])


def test_episodes_that_are_too_few_are_told(place: Path) -> None:
    allocate(scene=2, branch=2)
    episodes = roll(place)
    allocate(scene=2, branch=3)
    with pytest.raises(BelvedereError, match=f"holds 2 repeats.*dvc repro rollouts@{SCENE}"):
        shoot(episodes, place)
    assert not (place / "frames").exists()


def render_peak_bytes(place: Path, episodes: int) -> int:
    """The most bytes of arrays that are alive while the first repeat is rendered and written."""
    tree = yaml.safe_load((place / "params.yaml").read_text())
    tree["budgets"]["tiny"]["rollouts"] = {"episodes": episodes}
    (place / "params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")
    store = zarrs.Store(roll(place).with_suffix(""), zarrs.ROLLOUTS, "")
    studio = frames.Studio(load_scene(SCENE), viewpoint(SCENE, 0, 0))
    studio.repeat(store, 1)  # draws, and leaves what is compiled or made once
    tracemalloc.start()
    studio.repeat(store, 0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def test_memory_does_not_grow_with_episodes(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(zarrs, "SHARD_BYTES", 6 * EPISODE_BYTES)
    allocate(scene=2, branch=2)
    few, many = (render_peak_bytes(place, episodes) for episodes in (12, 48))
    assert many - few < (48 - 12) * EPISODE_BYTES / 4


def test_shards_change_no_picture(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    allocate(scene=2, branch=2)
    episodes = roll(place)
    whole = {name: shoot(episodes, place).repeat(name, 1) for name in zarrs.FRAMES}
    monkeypatch.setattr(zarrs, "SHARD_BYTES", 4 * EPISODE_BYTES)
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(place / "another"))
    store = shoot(episodes, place)
    assert len(list((place / "frames/repeat_1.zarr/rgb/c").iterdir())) == 2
    for name, array in whole.items():
        np.testing.assert_array_equal(store.repeat(name, 1), array)
    assert whole["target_pixels"].any()
