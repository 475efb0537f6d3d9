"""What a store's repeat has to hold to: axes of one length, and metadata as they were written."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.contract.errors import BelvedereError


def metadata_digest(folder: Path, attributes: Mapping[str, Any]) -> str:
    """A hash of all that a repeat says of itself: its attributes, and its arrays' metadata files.

    Zarr's codecs hold the numbers to their checksums, but nothing holds the metadata.
    """
    hasher = hashlib.sha256(json.dumps(dict(attributes), sort_keys=True).encode())
    for file in sorted(folder.glob("*/zarr.json")):
        hasher.update(b"\0" + file.parent.name.encode() + b"\0" + file.read_bytes())
    return hasher.hexdigest()


def check_shapes(
    path: Path, axes: Mapping[str, tuple[str, ...]], shapes: Mapping[str, tuple[int, ...]]
) -> None:
    """Holds the arrays of a repeat to their axes.

    Args:
        path: of the repeat, for the message.
        axes: of each array that there must be, its axes' names.
        shapes: of each array that there is.

    Raises:
        BelvedereError: an array is missing, has another number of axes, or an axis has two lengths.
    """
    sizes: dict[str, tuple[int, str]] = {}
    for name, dims in axes.items():
        if name not in shapes:
            raise BelvedereError(f"{path}: array {name} is missing.")
        if len(shapes[name]) != len(dims):
            raise BelvedereError(f"{path}: array {name} has shape {shapes[name]}; its axes are {dims}.")
        for dim, size in zip(dims, shapes[name], strict=True):
            known, owner = sizes.setdefault(dim, (size, name))
            if known != size:
                raise BelvedereError(
                    f"{path}: axis {dim} is {size} long in array {name} but {known} in {owner}."
                )
