"""Stores come back as they were written, and broken ones are refused in a sentence."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.storage import zarrs
from pipeline.storage.parts import InParts
from tests.damage import flipped
from tests.stores import write_store

REPEATS, EPISODES, FRAMES = 2, 3, 4


def rollouts(seed: int = 0) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    shape = (REPEATS, EPISODES, FRAMES)
    return {
        "qpos": rng.normal(size=(*shape, 9)).astype("f4"),
        "tip": rng.normal(size=(*shape, 3)).astype("f4"),
        "action": rng.uniform(-1, 1, size=(*shape, 2)).astype("f4"),
        "reward": rng.normal(size=shape).astype("f4"),
        "target": rng.normal(size=(REPEATS, EPISODES, 3)).astype("f4"),
    }


@pytest.fixture
def path(tmp_path: Path) -> Path:
    write_store(tmp_path / "a.zarr", zarrs.ROLLOUTS, rollouts(), {"scene": "panda_2dof"})
    return tmp_path / "a.zarr"


def opened(path: Path) -> zarrs.Store:
    return zarrs.Store(path, zarrs.ROLLOUTS, "rollouts")


def digests(path: Path) -> dict[str, str]:
    return {
        file.relative_to(path).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in path.rglob("*")
        if file.is_file()
    }


def shards(path: Path, array: str, repeat: int = 0) -> list[Path]:
    return sorted(file for file in (zarrs.place(path, repeat) / array / "c").rglob("*") if file.is_file())


def test_arrays_and_attributes_come_back(path: Path) -> None:
    store = opened(path)
    assert store.repeats == REPEATS
    assert store.attributes["scene"] == "panda_2dof"
    for name, array in rollouts().items():
        assert store.shape(name) == array.shape[1:]
        for repeat in range(REPEATS):
            np.testing.assert_array_equal(store.repeat(name, repeat), array[repeat])


def test_equal_contents_are_equal_bytes(path: Path, tmp_path: Path) -> None:
    write_store(tmp_path / "b.zarr", zarrs.ROLLOUTS, rollouts(), {"scene": "panda_2dof"})
    write_store(tmp_path / "c.zarr", zarrs.ROLLOUTS, rollouts(seed=1), {"scene": "panda_2dof"})
    assert digests(path) == digests(tmp_path / "b.zarr")
    assert digests(path) != digests(tmp_path / "c.zarr")


def test_one_more_repeat_leaves_the_others_as_they_are(path: Path) -> None:
    former = digests(path)
    more = {name: array[0] for name, array in rollouts(seed=1).items()}
    zarrs.write(zarrs.place(path, REPEATS), zarrs.ROLLOUTS, more, {"scene": "panda_2dof"})
    assert former.items() < digests(path).items()
    assert opened(path).repeats == REPEATS + 1
    np.testing.assert_array_equal(opened(path).repeat("qpos", REPEATS), more["qpos"])


@pytest.mark.parametrize("shard_bytes", [1, 200, 2**20])
def test_an_array_that_is_made_in_parts_is_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shard_bytes: int
) -> None:
    """It is made once, from the first episode to the last, before the others are written."""
    monkeypatch.setattr(zarrs, "SHARD_BYTES", shard_bytes)
    arrays = {name: array[0] for name, array in rollouts().items()}
    zarrs.write(tmp_path / "whole", zarrs.ROLLOUTS, arrays, {})
    filled, asked = np.zeros_like(arrays["reward"]), []

    def make(place: slice) -> np.ndarray:
        asked.extend(range(EPISODES)[place])
        filled[place] = arrays["reward"][place]
        return arrays["target"][place]

    in_parts = {"target": InParts(arrays["target"].shape, make), "reward": filled}
    zarrs.write(tmp_path / "in parts", zarrs.ROLLOUTS, arrays | in_parts, {})
    assert asked == list(range(EPISODES))
    assert digests(tmp_path / "in parts") == digests(tmp_path / "whole")


def test_some_episodes_are_those_of_the_whole(path: Path) -> None:
    store = opened(path)
    for place in (slice(0, 1), slice(1, 3), slice(None), slice(2, 2)):
        np.testing.assert_array_equal(store.episodes("qpos", 1, place), store.repeat("qpos", 1)[place])
    shards(path, "qpos")[0].write_bytes(b"")
    with pytest.raises(BelvedereError, match="lacks some of its data"):
        store.episodes("qpos", 0, slice(0, 1))


def test_large_arrays_are_split_into_shards_that_read_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(zarrs, "SHARD_BYTES", 2 * FRAMES * 9 * 4)  # two episodes of qpos
    write_store(tmp_path / "b.zarr", zarrs.ROLLOUTS, rollouts(), {})
    assert len(shards(tmp_path / "b.zarr", "qpos", 1)) == 2
    np.testing.assert_array_equal(opened(tmp_path / "b.zarr").repeat("qpos", 1), rollouts()["qpos"][1])


def test_names_units_and_axes_stand_in_the_store(path: Path) -> None:
    for name, column in zarrs.ROLLOUTS.items():
        described = json.loads((zarrs.place(path, 0) / name / "zarr.json").read_text(encoding="utf-8"))
        assert tuple(described["dimension_names"]) == column.dims
        assert described["attributes"]["unit"] == column.unit
        assert described["zarr_format"] == 3


def test_axes_that_disagree_are_refused_and_nothing_is_written(tmp_path: Path) -> None:
    arrays = rollouts()
    arrays["tip"] = arrays["tip"][:, :, :-1]
    with pytest.raises(BelvedereError, match="axis frame is 3 long in array tip but 4 in qpos"):
        write_store(tmp_path / "b.zarr", zarrs.ROLLOUTS, arrays, {})
    assert list(tmp_path.iterdir()) == []


def test_an_array_that_is_left_out_is_refused(tmp_path: Path) -> None:
    arrays = {name: array for name, array in rollouts().items() if name != "reward"}
    with pytest.raises(BelvedereError, match="array reward is missing"):
        write_store(tmp_path / "b.zarr", zarrs.ROLLOUTS, arrays, {})


def test_a_missing_store_names_the_stage_that_makes_it(tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match="is missing; `dvc repro rollouts` makes it"):
        opened(tmp_path / "none.zarr")


def test_a_folder_that_is_no_store_is_refused(tmp_path: Path) -> None:
    (tmp_path / "note.txt").write_text("no store")
    with pytest.raises(BelvedereError, match=r"it has no repeat_0\.zarr"):
        opened(tmp_path)
    zarrs.place(tmp_path, 0).mkdir()
    with pytest.raises(BelvedereError, match="no Zarr v3 group"):
        opened(tmp_path)


def test_a_store_that_lacks_a_repeat_between_others_is_refused(path: Path) -> None:
    shutil.rmtree(zarrs.place(path, 0))
    with pytest.raises(BelvedereError, match=r"repeat_0\.zarr is no Zarr v3 group"):
        opened(path)


def test_a_store_of_another_stage_is_refused(tmp_path: Path) -> None:
    shape = (REPEATS, EPISODES, FRAMES)
    latents = {
        "mean": np.zeros((*shape, 32)),
        "log_variance": np.zeros((*shape, 32)),
        "action": np.zeros((*shape, 2)),
        "reward": np.zeros(shape),
    }
    write_store(tmp_path / "a.zarr", zarrs.LATENTS, latents, {})
    with pytest.raises(BelvedereError, match="has no array qpos"):
        opened(tmp_path / "a.zarr")


def test_a_store_of_another_format_is_refused(path: Path) -> None:
    head = zarrs.place(path, 0) / "zarr.json"
    head.write_text(head.read_text().replace(f'"format": {zarrs.FORMAT}', '"format": 99'))
    with pytest.raises(BelvedereError, match=r"format of repeat_0\.zarr is 99"):
        opened(path)


def test_an_array_of_another_type_is_refused(path: Path, tmp_path: Path) -> None:
    schema = dict(zarrs.ROLLOUTS) | {"reward": zarrs.Column(zarrs.ROLLOUTS["reward"].dims, "float64", "m")}
    write_store(tmp_path / "b.zarr", schema, rollouts(), {})
    with pytest.raises(BelvedereError, match="array reward is float64, not float32"):
        opened(tmp_path / "b.zarr")


@pytest.mark.parametrize("kept", [0, 7, 100])
def test_a_truncated_shard_is_refused(path: Path, kept: int) -> None:
    shard = shards(path, "qpos")[0]
    shard.write_bytes(shard.read_bytes()[:kept])
    store = opened(path)
    with pytest.raises(BelvedereError, match=r"cannot be used: array qpos .*dvc repro rollouts"):
        store.repeat("qpos", 0)


def test_a_missing_shard_is_refused_rather_than_read_as_zeros(path: Path) -> None:
    shards(path, "qpos", 1)[0].unlink()
    with pytest.raises(BelvedereError, match=r"array qpos of repeat_1\.zarr lacks some of its data"):
        opened(path).repeat("qpos", 1)


def test_zeros_come_back_though_zarr_leaves_them_out_by_itself(tmp_path: Path) -> None:
    zeros = {name: np.zeros_like(array) for name, array in rollouts().items()}
    write_store(tmp_path / "b.zarr", zarrs.ROLLOUTS, zeros, {})
    for name, array in zeros.items():
        np.testing.assert_array_equal(opened(tmp_path / "b.zarr").repeat(name, 1), array[1])


@pytest.mark.parametrize("file", ["zarr.json", "qpos/zarr.json", "qpos/c/0/0/0", "target/c/0/0"])
def test_each_flipped_bit_is_refused_or_changes_nothing(path: Path, file: str) -> None:
    """Of metadata and numbers alike; what is refused is so in the words of a BelvedereError."""
    damaged = zarrs.place(path, 1) / file
    good, refused = damaged.read_bytes(), 0
    bits = range(
        0, 8 * len(good), 8 * len(good) // 100 + 1 | 1
    )  # odd, so that each of a byte's bits has its turn
    for bit in bits:
        damaged.write_bytes(flipped(good, bit))
        try:
            store = opened(path)
            found = {name: store.repeat(name, 1) for name in rollouts()}
        except BelvedereError as error:
            assert "dvc repro rollouts" in str(error)
            refused += 1
        else:
            assert store.attributes == {"scene": "panda_2dof"}
            for name, array in rollouts().items():
                np.testing.assert_array_equal(found[name], array[1])
    assert refused > 0.8 * len(bits)


@pytest.mark.parametrize("content", [b"", b"{", b"junk", b"null", b"{}", b"[]", b"\xff"])
@pytest.mark.parametrize("file", ["zarr.json", "tip/zarr.json"])
def test_damaged_metadata_are_refused(path: Path, file: str, content: bytes) -> None:
    (zarrs.place(path, 1) / file).write_bytes(content)
    with pytest.raises(BelvedereError, match=r"cannot be used: .*repeat_1.*dvc repro rollouts"):
        opened(path)


def test_a_missing_array_is_refused(path: Path) -> None:
    shutil.rmtree(zarrs.place(path, 0) / "tip")
    with pytest.raises(BelvedereError, match="has no array tip"):
        opened(path)


@pytest.mark.parametrize("repeat", [-1, REPEATS])
def test_a_repeat_that_is_not_there_is_refused(path: Path, repeat: int) -> None:
    with pytest.raises(BelvedereError, match=f"holds {REPEATS} repeats, and repeat {repeat}"):
        opened(path).repeat("qpos", repeat)
