"""Pictures and clips inside the page."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pipeline.contract.errors import BelvedereError
from pipeline.reporting.pictures import LARGE_WIDTH, THUMBNAIL_WIDTH, read_pictures


def _decoded(uri: str) -> Image.Image:
    head, content = uri.split(",", 1)
    assert head in ("data:image/png;base64", "data:image/webp;base64")
    return Image.open(io.BytesIO(base64.b64decode(content)))


def test_small_picture_comes_through_pixel_by_pixel(tmp_path: Path) -> None:
    pixels = np.random.default_rng(3).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    (tmp_path / "view").mkdir(exist_ok=True)
    Image.fromarray(pixels).save(tmp_path / "view" / "view_64.png")
    small = read_pictures(tmp_path, "study").small
    assert small is not None and (small.width, small.height) == (64, 64)
    np.testing.assert_array_equal(np.asarray(_decoded(small.uri)), pixels)


def test_large_picture_is_shrunk_in_proportion(tmp_path: Path) -> None:
    (tmp_path / "view").mkdir(exist_ok=True)
    Image.new("RGB", (1280, 960), (200, 30, 30)).save(tmp_path / "view" / "view.png")
    pictures = read_pictures(tmp_path, "study")
    for picture, width in ((pictures.large, LARGE_WIDTH), (pictures.thumbnail, THUMBNAIL_WIDTH)):
        assert picture is not None
        assert (picture.width, picture.height) == _decoded(picture.uri).size == (width, width * 3 // 4)


def test_still_of_a_clip_is_its_last_frame(tmp_path: Path) -> None:
    colours = [(220, 20, 20), (20, 220, 20), (20, 20, 220)]
    frames = [Image.new("RGB", (32, 32), colour) for colour in colours]
    frames[0].save(tmp_path / "clip.webp", save_all=True, append_images=frames[1:], duration=40)
    clip = read_pictures(tmp_path, "study").clip
    assert clip is not None and clip.still is not None
    assert getattr(_decoded(clip.uri), "n_frames", 1) == 3
    mean = np.asarray(_decoded(clip.still).convert("RGB")).mean(axis=(0, 1))
    np.testing.assert_allclose(mean, colours[-1], atol=12)


def test_nothing_there_is_no_error(tmp_path: Path) -> None:
    pictures = read_pictures(tmp_path / "absent", "study")
    assert (pictures.large, pictures.small, pictures.clip, pictures.reconstructions) == (None,) * 4


def test_truncated_picture_is_told(tmp_path: Path) -> None:
    pixels = np.random.default_rng(3).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    (tmp_path / "view").mkdir(exist_ok=True)
    Image.fromarray(pixels).save(tmp_path / "view" / "view_64.png")
    whole = (tmp_path / "view" / "view_64.png").read_bytes()
    (tmp_path / "view" / "view_64.png").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BelvedereError, match=r"view_64\.png is no picture; .*frames@study"):
        read_pictures(tmp_path, "study")
