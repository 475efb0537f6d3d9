"""Torch files that are whole or absent, and the same bytes for the same content."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch

from pipeline.contract.errors import BelvedereError
from pipeline.storage.archives import read_whole
from pipeline.storage.artefacts import writing


def save(path: Path, content: Mapping[str, Any]) -> None:
    """Writes tensors and plain values to ``path``, aside first."""
    # torch writes a file's own name into it, so a temporary name would change the bytes: use a buffer.
    buffer = io.BytesIO()
    torch.save(dict(content), buffer)
    with writing(path) as aside:
        aside.write_bytes(buffer.getbuffer())


def load(path: Path, made_by: str) -> dict[str, Any]:
    """Reads what :func:`save` wrote, onto the CPU.

    Args:
        path: the file.
        made_by: the stage that writes it, named when it is missing or foreign.

    Raises:
        BelvedereError: the file is missing, damaged or something else.
    """
    if not Path(path).is_file():
        raise BelvedereError(f"{path} is missing; `dvc repro {made_by}` makes it.")
    try:
        content = torch.load(read_whole(path), map_location="cpu", weights_only=True)
    except Exception as error:  # torch raises many types on a truncated or foreign file
        raise BelvedereError(
            f"{path} cannot be read ({type(error).__name__}); delete it and run `dvc repro {made_by}`."
        ) from None
    if not isinstance(content, dict):
        raise BelvedereError(f"{path} holds no weights; delete it and run `dvc repro {made_by}`.")
    return content
