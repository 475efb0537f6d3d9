"""Zarr v3 stores of episode × frame tables, one group per repeat, sharded, with a checked schema.

A store is a folder with the groups ``repeat_0.zarr``, ``repeat_1.zarr``, …, so that it grows by a repeat
without a change of the others. A shard holds many episodes, so a repeat is a few files and DVC stays fast.
Directory stores are byte-identical between identical runs (a ``ZipStore`` is not). Damage is told: chunks
carry Zstandard's checksum, shards' indices Zarr's, and a hash of the metadata stands beside the attributes.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import zarr
from zarr.codecs import ZstdCodec

from pipeline.contract.errors import BelvedereError
from pipeline.storage.artefacts import writing
from pipeline.storage.layouts import FRAMES, LATENTS, ROLLOUTS, TASK, Column, Schema
from pipeline.storage.parts import InParts, parts
from pipeline.storage.zarr_checks import check_shapes, metadata_digest

__all__ = ["FRAMES", "LATENTS", "ROLLOUTS", "TASK", "Column", "Schema", "Store", "place", "write"]

FORMAT = 3
SHARD_BYTES = 256 * 2**20  # an upper bound on a shard, far above quick's, for the paper budget


def place(folder: Path, repeat: int) -> Path:
    """Where a store in ``folder`` keeps a repeat."""
    return folder / f"repeat_{repeat}.zarr"


def write(
    path: Path, schema: Schema, arrays: Mapping[str, np.ndarray | InParts], attributes: Mapping[str, Any]
) -> None:
    """Writes one repeat whole, a shard at a time; what is made in parts is made and written first.

    Args:
        path: the repeat's own folder, see :func:`place`.
        schema: which arrays there must be; those of :data:`TASK` may be there.
        arrays: one array per column of the schema; shapes must agree on shared axis names.
        attributes: JSON-able facts that all repeats of a store share (scene, viewpoint, versions, …).
    """
    schema = _present(schema, arrays)
    _check_axes(path, schema, arrays)
    with writing(Path(path)) as aside:
        group = zarr.create_group(str(aside))
        for name in sorted(schema, key=lambda name: not isinstance(arrays[name], InParts)):
            column, array = schema[name], arrays[name]
            chunks, shards = _layout(array.shape, np.dtype(column.dtype).itemsize)
            stored = group.create_array(
                name,
                shape=array.shape,
                dtype=column.dtype,
                chunks=chunks,
                shards=shards,
                compressors=ZstdCodec(level=0, checksum=True),
                dimension_names=column.dims,
                attributes={"unit": column.unit},
                config={"write_empty_chunks": True},  # or zeros would be as if data were lacking
            )
            for place, part in parts(array, shards[0]):
                stored[place] = np.ascontiguousarray(part, dtype=column.dtype)
        digest = metadata_digest(aside, attributes)
        group.attrs.update({**attributes, "format": FORMAT, "metadata_digest": digest})


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
        self.attributes = _facts(self._groups[0])

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

    def has(self, name: str) -> bool:
        """Whether the store holds array ``name`` of :data:`TASK`."""
        return name in self._groups[0]

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
        try:
            schema = _present(schema, set(group))
            arrays: dict[str, Any] = {name: group.get(name) for name in schema}
        except Exception as error:  # as above
            raise self._broken(f"the arrays of {path.name} cannot be read ({type(error).__name__})") from None
        missing = [name for name, array in arrays.items() if not isinstance(array, zarr.Array)]
        if missing:
            raise self._broken(f"{path.name} has no array {', '.join(missing)}")
        if group.attrs.get("metadata_digest") != metadata_digest(path, _facts(group)):
            raise self._broken(f"the metadata of {path.name} are not as they were written")
        for name, column in schema.items():
            if str(arrays[name].dtype) != column.dtype:
                raise self._broken(f"array {name} is {arrays[name].dtype}, not {column.dtype}")
        _check_axes(path, schema, arrays)
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


def _facts(group: zarr.Group) -> dict[str, Any]:
    """The attributes that :func:`write` was given."""
    return {name: value for name, value in group.attrs.items() if name not in ("format", "metadata_digest")}


def _present(schema: Schema, arrays: Collection[str]) -> Schema:
    """The schema with those of a task's columns that are there."""
    return {**schema, **{name: column for name, column in TASK.items() if name in arrays}}


def _check_axes(path: Path, schema: Schema, arrays: Mapping[str, Any]) -> None:
    axes = {name: column.dims for name, column in schema.items()}
    check_shapes(path, axes, {name: array.shape for name, array in arrays.items()})
