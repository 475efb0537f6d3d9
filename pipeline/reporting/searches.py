"""The page's section on searches over the sphere: the answer, a map, the finalists, and all candidates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import polars as pl
from markupsafe import Markup

from pipeline.reporting.csv_frames import read_frame
from pipeline.reporting.pictures import Picture, read_thumbnail
from pipeline.reporting.search_tables import Mounting, Search
from pipeline.reporting.sphere import sphere_plot
from pipeline.reporting.tried import TriedScene
from pipeline.storage.tables import read_model

MAP_COLUMNS = {"theta_deg": pl.Float64, "phi_deg": pl.Float64, "mean": pl.Float64, "sd": pl.Float64}


@dataclass(frozen=True)
class SearchResults:
    """A search as its stages left it.

    Attributes:
        found: the search.
        surface: the map, columns :data:`MAP_COLUMNS`.
        mounting: what finalists lose off their places, best first; of those that were tried.
    """

    found: Search
    surface: pl.DataFrame
    mounting: dict[str, Mounting]


@dataclass(frozen=True)
class SearchPage:
    """A search with what the template places.

    Attributes:
        results: the search.
        map: the sphere.
        thumbnails: of the finalists, by branch.
    """

    results: SearchResults
    map: Markup
    thumbnails: dict[str, Picture]


def read_searches(folder: Path) -> list[SearchResults]:
    """Each scene's search, in the order of their names; none where nothing was searched.

    Raises:
        BelvedereError: a table is foreign, or a map is missing.
    """
    found = []
    for file in sorted(folder.glob("*/search.json")):
        scene = file.parent.name
        search = read_model(Search, file, f"search/dvc.yaml:search@{scene}")
        remedy = f"`./run search {scene}` makes it"
        surface = read_frame(file.with_name("map.csv"), MAP_COLUMNS, "map", remedy)
        found.append(SearchResults(search, surface, _mounting(search, file.with_name("mounting"))))
    return found


def search_pages(
    searches: Sequence[SearchResults], tried: Sequence[TriedScene], folder: Path
) -> list[SearchPage]:
    """The searches of a folder, drawn; viewpoints that experiments tried stand on the map, too."""
    pages = []
    for results in searches:
        name = results.found.scene
        rows = [row for scene in tried if scene.name == name for row in scene.rows]
        drawn = Markup(sphere_plot(results.found, results.surface, rows))
        pages.append(SearchPage(results, drawn, _thumbnails(results.found, folder / name / "pictures")))
    return pages


def _mounting(search: Search, folder: Path) -> dict[str, Mounting]:
    files = {row.key: folder / f"{row.key}.json" for row in search.viewpoints}
    made_by = "search/dvc.yaml:mounting@"
    found = {k: read_model(Mounting, f, f"{made_by}{k}") for k, f in files.items() if f.is_file()}
    places = {key: (one.theta_deg, one.phi_deg) for key, one in search.candidates.items()}
    return {key: own for key, own in found.items() if (own.theta_deg, own.phi_deg) == places[key]}


def _thumbnails(search: Search, folder: Path) -> dict[str, Picture]:
    """Of the finalists whose pictures are on this machine."""
    found = {}
    for row in search.viewpoints:
        picture = read_thumbnail(folder / f"{row.key}.png", f"search/dvc.yaml:frames@{row.key}")
        if picture is not None:
            found[row.key] = picture
    return found
