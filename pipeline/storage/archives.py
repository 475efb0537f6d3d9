"""Zip archives (``.npz``, ``.pt``), held to the checksums that they carry; NumPy and torch do not do so."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path


def read_whole(path: Path) -> io.BytesIO:
    """The bytes of an archive, each of whose members has been held to its CRC-32.

    Raises:
        zipfile.BadZipFile: a checksum is wrong; an archive that is damaged elsewhere surfaces as an error of
            one of many types.
    """
    content = io.BytesIO(Path(path).read_bytes())
    with zipfile.ZipFile(content) as archive:
        damaged = archive.testzip()
    if damaged is not None:
        raise zipfile.BadZipFile(f"the checksum of {damaged} is wrong")
    content.seek(0)
    return content
