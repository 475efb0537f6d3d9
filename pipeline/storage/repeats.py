"""Repeats, each made once per inputs, parameters, code and machine kind, and how they are published."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.storage import scratch, zarrs
from pipeline.storage.artefacts import aside_of, read_json, remove_leftovers, write_json, writing
from pipeline.storage.manifest import mismatch, write_manifest

REPEAT = "repeat.zarr"  # of a store, in the folder of a repeat's results


@dataclass(frozen=True)
class Place:
    """Where a repeat is made: the folder of its results, and that of its checkpoints while it runs."""

    results: Path
    running: Path


def finished(stage: str, repeat: int, make: Callable[[Path, Path], None], **cache_key: Any) -> Path:
    """The folder of a repeat's results: from the scratch store, or made now.

    Args:
        stage: the stage's name.
        repeat: which repeat.
        make: called as ``make(results, running)`` where nothing is finished yet; writes its results
            into the folder ``results`` and, as it goes, checkpoints into the folder ``running``,
            where it finds them again after it was killed.
        **cache_key: JSON-able values that decide the result (see :func:`pipeline.storage.scratch.folder`).

    Returns:
        A folder that is complete and must not be changed.
    """

    def make_one(places: Mapping[int, Place]) -> None:
        make(places[repeat].results, places[repeat].running)

    return finished_together(stage, {repeat: cache_key}, make_one)[0]


def finished_together(
    stage: str, cache_keys: Mapping[int, Mapping[str, Any]], make: Callable[[Mapping[int, Place]], None]
) -> list[Path]:
    """The folders of several repeats' results; those that the scratch store lacks are made in one go.

    Results that are not what their manifest says count as lacking.

    Args:
        stage: the stage's name.
        cache_keys: of each repeat, what decides its result.
        make: called with the places of the repeats that are not finished yet, if there are any.

    Returns:
        A folder for each repeat, complete, which must not be changed.
    """
    homes = {repeat: scratch.folder(stage, repeat, **facts) for repeat, facts in cache_keys.items()}
    with scratch.locked(homes.values()):
        _make_missing(homes, make)
    return [home / "results" for home in homes.values()]


def _make_missing(homes: Mapping[int, Path], make: Callable[[Mapping[int, Place]], None]) -> None:
    missing = {repeat: home / "results" for repeat, home in homes.items() if not _is_whole(home / "results")}
    places = {r: Place(aside_of(results), results.with_name("running")) for r, results in missing.items()}
    for repeat, place in places.items():
        remove_leftovers(missing[repeat])
        place.running.mkdir(exist_ok=True)
        shutil.rmtree(place.results, ignore_errors=True)
        place.results.mkdir()
    if places:
        make(places)
    for repeat, place in places.items():
        write_manifest(place.results)
        shutil.rmtree(missing[repeat], ignore_errors=True)
        place.results.replace(missing[repeat])
    for home in homes.values():
        shutil.rmtree(home / "running", ignore_errors=True)


def _is_whole(results: Path) -> bool:
    """Whether there are results as they were written; says so where they are not."""
    if not results.is_dir():
        return False
    why = mismatch(results)
    if why:
        print(f"{results} is damaged ({why}); the repeat is made again.")
    return why is None


def publish_store(out: Path, results: Sequence[Path]) -> None:
    """Writes a store of the repeats' results, each a folder that holds one repeat as ``repeat.zarr``.

    Files are linked rather than copied where the file system can: nothing changes them in place.
    """
    with writing(out) as folder:
        folder.mkdir()
        for repeat, result in enumerate(results):
            shutil.copytree(result / REPEAT, zarrs.place(folder, repeat), copy_function=_link)


def _link(source: str, target: str) -> None:
    try:
        os.link(source, target)
    except OSError:  # another file system, or one without links
        shutil.copy2(source, target)


def publish(
    out: Path, metrics: Path, attributes: Mapping[str, Any], results: Sequence[Path], stage: str
) -> None:
    """Writes a branch's weights as ``out/repeat_{r}.pt`` and its metrics.

    Args:
        out: folder.
        metrics: JSON file.
        attributes: of the branch's store, see :func:`branch_metrics`.
        results: of each repeat, a folder with ``weights.pt`` and ``metrics.json``.
        stage: who does so.
    """
    numbers = branch_metrics(attributes, [read_json(r / "metrics.json", stage) for r in results])
    with writing(out) as folder:
        folder.mkdir()
        for repeat, result in enumerate(results):
            shutil.copyfile(result / "weights.pt", folder / f"repeat_{repeat}.pt")
    write_json(metrics, numbers)


def branch_metrics(attributes: Mapping[str, Any], repeats: Sequence[Mapping[str, float]]) -> dict[str, Any]:
    """A branch's metrics: its viewpoint, each repeat's numbers, and their means as ``…_mean``.

    Args:
        attributes: of the branch's store; ``scene``, ``theta_deg`` and ``phi_deg`` are taken.
        repeats: numbers of each repeat; all with the same names.
    """
    viewpoint = {name: attributes[name] for name in ("scene", "theta_deg", "phi_deg")}
    numbered = [{"repeat": index, **numbers} for index, numbers in enumerate(repeats)]
    means = {f"{name}_mean": sum(r[name] for r in repeats) / len(repeats) for name in repeats[0]}
    return {**viewpoint, "repeats": numbered, **means}
