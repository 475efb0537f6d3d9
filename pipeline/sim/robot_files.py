"""A robot's files: where the declared one lies, which others it reads, and what is wrong with them."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

from pipeline.contract.errors import BelvedereError

FOLDER = Path("robots")  # of the repository; stage `scene` depends on it
_KINDS = (".xml", ".urdf")
_PREFIX = re.compile(rb"(?:</?|\s)([A-Za-z][\w.-]*):(?=[\w.-]+[\s=/>])")
_SHOWN = 12  # names in a message


def robot_file(name: str, file: str, root: Path) -> Path:
    """Where the file lies that robot ``name`` declares.

    Args:
        name: the robot.
        file: ``robots/…`` in the repository, or ``PACKAGE:path/inside.xml``.
        root: the repository's root.

    Raises:
        BelvedereError: it is missing, of another kind, or elsewhere.
    """
    package, colon, inside = file.partition(":")
    place = _in_package(name, package, inside) if colon else _in_repository(name, file, root)
    require(place, f"robot {name}: file {file}")
    if place.suffix.lower() not in _KINDS:
        raise BelvedereError(
            f"robot {name}: file {file} is neither MJCF (.xml) nor URDF (.urdf); a xacro has to be expanded "
            "first (`xacro robot.urdf.xacro > robot.urdf`)."
        )
    return place


def _in_repository(name: str, file: str, root: Path) -> Path:
    place = root / file
    if Path(file).is_absolute() or not _within(place, root / FOLDER):
        raise BelvedereError(
            f"robot {name}: file {file} does not lie in the repository's folder {FOLDER}/, whose changes "
            "invalidate results; copy the robot's files there, or name one in a Python package as "
            "PACKAGE:path/inside.xml."
        )
    return place


def _in_package(name: str, package: str, inside: str) -> Path:
    found = find_spec(package) if re.fullmatch(r"\w+", package) else None
    if found is None or not found.submodule_search_locations:
        raise BelvedereError(
            f"robot {name}: there is no Python package {package!r} in the environment, of which {inside} was "
            f"declared; `./run python -m pip install {package.replace('_', '-')}` may bring it."
        )
    root = Path(found.submodule_search_locations[0])
    if not inside or Path(inside).is_absolute() or not _within(root / inside, root):
        raise BelvedereError(f"robot {name}: {inside!r} is no path inside the Python package {package}.")
    return root / inside


def _within(path: Path, folder: Path) -> bool:
    return Path(os.path.normpath(path)).is_relative_to(os.path.normpath(folder))


def require(path: Path, what: str) -> None:
    """Raises a :class:`BelvedereError` about ``what``, telling what exists instead, if it is missing."""
    if path.is_file():
        return
    there = path.parent
    while not there.is_dir():
        there = there.parent
    names = sorted(entry.name + "/" * entry.is_dir() for entry in there.iterdir())
    shown = ", ".join(names[:_SHOWN]) + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")
    raise BelvedereError(f"{what} is missing: there is no {path}; {there} has {shown or 'nothing'}.")


def unreadable(name: str, file: Path, error: ValueError) -> BelvedereError:
    """What to say of a file with which MuJoCo finds fault."""
    return BelvedereError(f"robot {name}: MuJoCo cannot read {file}: {' '.join(str(error).split())}.")


def read_xml(name: str, path: Path) -> ElementTree.Element:
    """The root element of an XML file; undeclared prefixes, as in many URDFs, are taken as names.

    Raises:
        BelvedereError: it is no XML.
    """
    try:
        text = path.read_bytes()
        for prefix in set(_PREFIX.findall(text)) - {b"xmlns"}:
            if b"xmlns:" + prefix not in text:
                text = re.sub(rb"(</?|\s)" + prefix + rb":", rb"\1" + prefix + rb"_", text)
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise BelvedereError(f"robot {name}: {path} is no XML: {error}.") from None


def files_read(name: str, main: Path) -> list[Path]:
    """An MJCF file, its includes, and the meshes and textures that they name, each once.

    Raises:
        BelvedereError: one of them is missing.
    """
    trees: dict[Path, ElementTree.Element] = {}
    _read_with_includes(name, main, main, trees)
    folders: dict[str, str] = {}
    for tree in trees.values():
        for compiler in tree.iter("compiler"):
            folders |= compiler.attrib
    found = list(trees)
    for path, tree in trees.items():
        for kind, file in _assets(tree):
            if kind == "model":
                require(main.parent / file, f"robot {name}: {file}, which {path.name} names,")
                found += files_read(name, main.parent / file)
                continue
            inner = folders.get({"texture": "texturedir"}.get(kind, "meshdir"), folders.get("assetdir", ""))
            place = main.parent / inner / (Path(file).name if folders.get("strippath") == "true" else file)
            require(place, f"robot {name}: {kind} {file}, which {path.name} names,")
            found.append(place)
    return list(dict.fromkeys(found))


def _read_with_includes(
    name: str, path: Path, main: Path, trees: dict[Path, ElementTree.Element], named_in: str = ""
) -> None:
    if path in trees:
        return
    require(path, f"robot {name}: {path.name}{named_in}")
    trees[path] = read_xml(name, path)
    for include in trees[path].iter("include"):
        file = include.get("file", "")
        beside_main, beside = main.parent / file, path.parent / file
        inner = beside_main if beside_main.is_file() or not beside.is_file() else beside
        _read_with_includes(name, inner, main, trees, f", which {path.name} includes,")


def _assets(tree: ElementTree.Element) -> Iterator[tuple[str, str]]:
    """What a file names of other files but includes: the element's kind, and the path as it stands there."""
    for element in tree.iter():
        for attribute, value in element.attrib.items():
            if attribute.startswith("file") and element.tag in ("mesh", "hfield", "skin", "texture", "model"):
                yield element.tag, value


def digests(files: Iterable[Path]) -> dict[str, str]:
    """The sha256 of each file, by its path from the first one's folder, wherever that lies."""
    listed = list(files)
    return {
        Path(os.path.relpath(file, listed[0].parent)).as_posix(): hashlib.sha256(
            file.read_bytes()
        ).hexdigest()
        for file in listed
    }
