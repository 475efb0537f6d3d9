"""The page's section on searches over the sphere: the answer, a map, the finalists, and all candidates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import polars as pl
from markupsafe import Markup

from pipeline.reporting.csv_frames import read_frame
from pipeline.reporting.pictures import Pictures, read_pictures
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
    pictures: dict[str, Pictures]


def read_searches(folder: Path) -> list[tuple[Search, pl.DataFrame]]:
    """Each search and its map, in the order of the scenes' names; none where nothing was searched.

    Raises:
        BelvedereError: a table is foreign, or a map is missing.
    """
    found = []
    for file in sorted(folder.glob("*.json")):
        made_by = f"search/dvc.yaml:search@{file.stem}"
        search = read_model(Search, file, made_by)
        remedy = f"`dvc repro {made_by}` makes it"
        found.append((search, read_frame(folder / f"{file.stem}_map.csv", MAP_COLUMNS, "map", remedy)))
    return found


def search_pages(
    searches: Sequence[tuple[Search, pl.DataFrame]], tried: Sequence[TriedScene], pictures: Path
) -> list[SearchPage]:
    """The searches drawn; viewpoints that experiments tried in the scene stand on its map, too."""
    pages = []
    for search, surface in searches:
        rows = [row for scene in tried if scene.name == search.scene for row in scene.rows]
        shown = {row.key: read_pictures(pictures / row.key, row.key) for row in search.viewpoints}
        pages.append(SearchPage(search, Markup(sphere_plot(search, surface, rows)), shown))
    return pages
