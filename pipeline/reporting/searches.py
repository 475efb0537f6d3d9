"""The page's section on searches over the sphere: the answer, a map, the finalists, and all candidates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import polars as pl
from markupsafe import Markup

from pipeline.reporting.csv_frames import read_frame
from pipeline.reporting.pictures import Picture, read_thumbnail
from pipeline.reporting.search_tables import Search
from pipeline.reporting.sphere import sphere_plot
from pipeline.reporting.tried import TriedScene
from pipeline.storage.tables import read_model

MAP_COLUMNS = {"theta_deg": pl.Float64, "phi_deg": pl.Float64, "mean": pl.Float64, "sd": pl.Float64}


@dataclass(frozen=True)
class SearchPage:
    """A search with what the template places."""

    found: Search
    map: Markup
    thumbnails: dict[str, Picture]


def read_searches(folder: Path) -> list[tuple[Search, pl.DataFrame]]:
    """Each search and its map, in the order of the scenes' names; none where nothing was searched.

    Raises:
        BelvedereError: a table is foreign, or a map is missing.
    """
    found = []
    for file in sorted(folder.glob("*/search.json")):
        scene = file.parent.name
        search = read_model(Search, file, f"search/dvc.yaml:search@{scene}")
        remedy = f"`./run search {scene}` makes it"
        surface = read_frame(file.with_name("map.csv"), MAP_COLUMNS, "map", remedy)
        found.append((search, surface))
    return found


def search_pages(
    searches: Sequence[tuple[Search, pl.DataFrame]], tried: Sequence[TriedScene], folder: Path
) -> list[SearchPage]:
    """The searches of a folder, drawn; viewpoints that experiments tried stand on the map, too."""
    pages = []
    for search, surface in searches:
        rows = [row for scene in tried if scene.name == search.scene for row in scene.rows]
        drawn = Markup(sphere_plot(search, surface, rows))
        pages.append(SearchPage(search, drawn, _thumbnails(search, folder / search.scene / "pictures")))
    return pages


def _thumbnails(search: Search, folder: Path) -> dict[str, Picture]:
    """Of the finalists whose pictures are on this machine."""
    found = {}
    for row in search.viewpoints:
        picture = read_thumbnail(folder / f"{row.key}.png", f"search/dvc.yaml:frames@{row.key}")
        if picture is not None:
            found[row.key] = picture
    return found
