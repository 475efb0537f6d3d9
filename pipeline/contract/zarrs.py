"""Zarr v3 stores of episode × frame tables, one group per repeat, sharded, with a checked schema.

A store is a folder with the groups ``repeat_0.zarr``, ``repeat_1.zarr``, …, so that it grows by a repeat
without a change of the others. A shard holds many episodes, so a repeat is a few files and DVC stays fast.
Directory stores are byte-identical between identical runs (a ``ZipStore`` is not).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import zarr

from pipeline.contract.artefacts import writing
from pipeline.contract.errors import BelvedereError
from pipeline.contract.parts import InParts, parts

FORMAT = 2
SHARD_BYTES = 256 * 2**20  # an upper bound on a shard, far above quick's, for the paper budget


@dataclass(frozen=True)
class Column:
    """One named array of a store.

    Attributes:
        dims: axis names; the first is ``episode``.
        dtype: NumPy dtype name.
        unit: physical unit, or what the numbers are.
    """

    dims: tuple[str, ...]
    dtype: str
    unit: str


Schema = Mapping[str, Column]

_EPISODE = ("episode",)
_FRAME = ("episode", "frame")

ROLLOUTS: Schema = {
    "qpos": Column((*_FRAME, "coordinate"), "float32", "MuJoCo generalised positions (rad, m)"),
    "tip": Column((*_FRAME, "xyz"), "float32", "m, world frame, before the action"),
    "action": Column((*_FRAME, "axis"), "float32", "share of the largest displacement, -1 to 1"),
    "reward": Column(_FRAME, "float32", "m, eq. (1), after the action"),
    "target": Column((*_EPISODE, "xyz"), "float32", "m, world frame"),
}
FRAMES: Schema = {
    "rgb": Column((*_FRAME, "row", "column", "channel"), "uint8", "sRGB, 0 to 255"),
    "tip": ROLLOUTS["tip"],
    "action": ROLLOUTS["action"],
    "reward": ROLLOUTS["reward"],
    "target": ROLLOUTS["target"],
    "target_pixels": Column(_FRAME, "int32", "pixels in which the target is seen"),
    "target_pixels_free": Column(_EPISODE, "int32", "the same, were nothing in front of it"),
}
LATENTS: Schema = {
    "mean": Column((*_FRAME, "latent"), "float32", "posterior mean of z"),
    "log_variance": Column((*_FRAME, "latent"), "float32", "posterior log variance of z"),
    "action": ROLLOUTS["action"],
    "reward": ROLLOUTS["reward"],
}


def place(folder: Path, repeat: int) -> Path:
    """Where a store in ``folder`` keeps a repeat."""
    return folder / f"repeat_{repeat}.zarr"


def write(
    path: Path, schema: Schema, arrays: Mapping[str, np.ndarray | InParts], attributes: Mapping[str, Any]
) -> None:
    """Writes one repeat whole, a shard at a time; what is made in parts is made and written first.

    Args:
        path: the repeat's own folder, see :func:`place`.
        schema: which arrays there must be.
        arrays: one array per column of the schema; shapes must agree on shared axis names.
        attributes: JSON-able facts that all repeats of a store share (scene, viewpoint, versions, …).
    """
    _check_shapes(path, schema, {name: a.shape for name, a in arrays.items()})
    with writing(Path(path)) as aside:
        group = zarr.create_group(str(aside), attributes={**attributes, "format": FORMAT})
        for name in sorted(schema, key=lambda name: not isinstance(arrays[name], InParts)):
            column, array = schema[name], arrays[name]
            chunks, shards = _layout(array.shape, np.dtype(column.dtype).itemsize)
            stored = group.create_array(
                name,
                shape=array.shape,
                dtype=column.dtype,
                chunks=chunks,
                shards=shards,
                dimension_names=column.dims,
                attributes={"unit": column.unit},
            )
            for place, part in parts(array, shards[0]):
                stored[place] = np.ascontiguousarray(part, dtype=column.dtype)


def _layout(shape: tuple[int, ...], item_bytes: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """One episode a chunk; as many episodes a shard as ``SHARD_BYTES`` allow."""
    rest = shape[1:]
    episode_bytes = int(np.prod(rest, dtype=np.int64)) * item_bytes
    episodes = max(1, min(shape[0], SHARD_BYTES // max(1, episode_bytes)))
    return (1, *rest), (episodes, *rest)


class Store:
    """A store opened for reading; the schema of every repeat has been checked.

    Args:
        path: the store's folder.
        schema: the arrays that must be there.
        made_by: the stage that writes such a store, named in errors.
    """

    def __init__(self, path: Path, schema: Schema, made_by: str) -> None:
        self.path, self._made_by = Path(path), made_by
        if not self.path.exists():
            raise BelvedereError(f"{path} is missing; `dvc repro {made_by}` makes it.")
        found = len(list(self.path.glob("repeat_*.zarr")))
        self._groups = [self._open(repeat, schema) for repeat in range(found)]
        if not self._groups:
            raise self._broken("it has no repeat_0.zarr")
        self.attributes: dict[str, Any] = dict(self._groups[0].attrs)

    @property
    def repeats(self) -> int:
        return len(self._groups)

    def place(self, repeat: int) -> Path:
        """The folder of one repeat.

        Raises:
            BelvedereError: there is no such repeat.
        """
        if not 0 <= repeat < self.repeats:
            raise self._broken(f"it holds {self.repeats} repeats, and repeat {repeat} was asked for")
        return place(self.path, repeat)

    def shape(self, name: str) -> tuple[int, ...]:
        """The shape of array ``name`` in the first repeat: ``(episode, …)``."""
        return tuple(self._array(name, 0).shape)

    def repeat(self, name: str, repeat: int) -> np.ndarray:
        """One repeat's array ``name``: shape ``(episode, …)``; raises as :meth:`episodes` does."""
        return self.episodes(name, repeat, slice(None))

    def episodes(self, name: str, repeat: int, place: slice) -> np.ndarray:
        """Some episodes of one repeat's array ``name``: shape ``(episode, …)``.

        Raises:
            BelvedereError: the data cannot be read or is cut short.
        """
        where = self.place(repeat)
        array = self._array(name, repeat)
        self._refuse_missing_shards(where / name, array)
        try:
            return np.asarray(array[place])
        except Exception as error:  # a truncated shard surfaces as one of many types
            raise self._broken(
                f"array {name} of repeat {repeat} cannot be read ({type(error).__name__})"
            ) from None

    def _open(self, repeat: int, schema: Schema) -> zarr.Group:
        path = place(self.path, repeat)
        try:
            group = zarr.open_group(str(path), mode="r")
        except Exception as error:  # zarr raises many types on a foreign or truncated store
            raise self._broken(f"{path.name} is no Zarr v3 group ({type(error).__name__})") from None
        if group.attrs.get("format") != FORMAT:
            raise self._broken(f"the format of {path.name} is {group.attrs.get('format')!r}, not {FORMAT}")
        missing = [name for name in schema if not isinstance(group.get(name), zarr.Array)]
        if missing:
            raise self._broken(f"{path.name} has no array {', '.join(missing)}")
        arrays: dict[str, Any] = {name: group[name] for name in schema}
        for name, column in schema.items():
            if str(arrays[name].dtype) != column.dtype:
                raise self._broken(f"array {name} is {arrays[name].dtype}, not {column.dtype}")
        _check_shapes(path, schema, {name: array.shape for name, array in arrays.items()})
        return group

    def _array(self, name: str, repeat: int) -> Any:
        return self._groups[repeat][name]

    def _refuse_missing_shards(self, folder: Path, array: Any) -> None:
        """Zarr reads a missing or empty shard as zeros, which would train a network on nothing."""
        empty = any(f.is_file() and not f.stat().st_size for f in folder.rglob("*"))
        if empty or array.nchunks_initialized < array.nchunks:
            raise self._broken(f"array {folder.name} of {folder.parent.name} lacks some of its data")

    def _broken(self, why: str) -> BelvedereError:
        return BelvedereError(
            f"{self.path} cannot be used: {why}; delete it and run `dvc repro {self._made_by}`."
        )


def _check_shapes(path: Path, schema: Schema, shapes: Mapping[str, tuple[int, ...]]) -> None:
    sizes: dict[str, tuple[int, str]] = {}
    for name, column in schema.items():
        if name not in shapes:
            raise BelvedereError(f"{path}: array {name} is missing.")
        if len(shapes[name]) != len(column.dims):
            raise BelvedereError(
                f"{path}: array {name} has shape {shapes[name]}; its axes are {column.dims}."
            )
        for dim, size in zip(column.dims, shapes[name], strict=True):
            known, owner = sizes.setdefault(dim, (size, name))
            if known != size:
                raise BelvedereError(
                    f"{path}: axis {dim} is {size} long in array {name} but {known} in {owner}."
                )
