"""Pictures and clips as data inside the page."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from pathlib import Path

from PIL import Image, UnidentifiedImageError

from pipeline.contract.errors import BelvedereError

LARGE_WIDTH = 640
THUMBNAIL_WIDTH = 220
QUALITY = 82


@dataclass(frozen=True)
class Picture:
    """A picture inside the page; size in its own pixels.

    Attributes:
        uri: ``data:`` address.
        width, height: pixels.
        still: of a clip, its last frame, for those who want no motion.
    """

    uri: str
    width: int
    height: int
    still: str | None = None


@dataclass(frozen=True)
class Pictures:
    """A branch's pictures; None where one is not on this machine."""

    large: Picture | None
    thumbnail: Picture | None
    small: Picture | None
    reconstructions: Picture | None
    clip: Picture | None


def read_pictures(folder: Path, key: str) -> Pictures:
    """Reads the pictures of branch ``key`` from its folder, where there are any.

    Raises:
        BelvedereError: a file is there but is no picture.
    """
    return Pictures(
        large=_shrunk(folder / "view" / "view.png", LARGE_WIDTH, f"frames@{key}"),
        thumbnail=_shrunk(folder / "view" / "view.png", THUMBNAIL_WIDTH, f"frames@{key}"),
        small=_as_it_is(folder / "view" / "view_64.png", f"frames@{key}"),
        reconstructions=_as_it_is(folder / "reconstructions.png", f"vae@{key}"),
        clip=_clip(folder / "clip.webp", f"evaluation@{key}"),
    )


def read_thumbnail(path: Path, made_by: str) -> Picture | None:
    """A small version of a picture of a view; ``None`` where it is not on this machine.

    Raises:
        BelvedereError: the file is no picture.
    """
    return _shrunk(path, THUMBNAIL_WIDTH, made_by)


def _open(path: Path, made_by: str) -> Image.Image | None:
    if not path.is_file():
        return None
    try:
        image = Image.open(path)
        image.load()
    except (UnidentifiedImageError, OSError, SyntaxError):  # Pillow raises each on damaged files
        raise BelvedereError(f"{path} is no picture; delete it and run `dvc repro {made_by}`.") from None
    return image


def _uri(kind: str | None, content: bytes) -> str:
    return f"data:image/{(kind or 'png').lower()};base64,{base64.b64encode(content).decode()}"


def _as_it_is(path: Path, made_by: str) -> Picture | None:
    image = _open(path, made_by)
    if image is None:
        return None
    return Picture(_uri(image.format, path.read_bytes()), image.width, image.height)


def _shrunk(path: Path, width: int, made_by: str) -> Picture | None:
    """At most ``width`` pixels wide and as lossy WebP: a tenth of the PNG."""
    image = _open(path, made_by)
    if image is None:
        return None
    if image.width > width:
        image = image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)
    return Picture(_uri("webp", _webp(image)), image.width, image.height)


def _clip(path: Path, made_by: str) -> Picture | None:
    image = _open(path, made_by)
    if image is None:
        return None
    image.seek(getattr(image, "n_frames", 1) - 1)
    last = _uri("webp", _webp(image))
    return Picture(_uri(image.format, path.read_bytes()), image.width, image.height, still=last)


def _webp(image: Image.Image) -> bytes:
    buffer = io.BytesIO()
    image.convert("RGB").save(buffer, "WEBP", quality=QUALITY, method=4)
    return buffer.getvalue()
