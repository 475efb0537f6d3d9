"""URDF as MuJoCo should read it: visuals and fixed links kept, meshes found, ROS's package:// resolved."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from pipeline.contract.errors import BelvedereError
from pipeline.sim.robot_files import read_xml, require

_PACKAGE = "package://"
_READ = (".stl", ".obj", ".msh")
# MuJoCo drops visuals and joins fixed links, such as tool0, unless told not to. Paths are absolute here.
_COMPILER = {"discardvisual": "false", "fusestatic": "false", "strippath": "false", "meshdir": ""}


def urdf_text(name: str, file: Path) -> tuple[str, list[Path]]:
    """The text for MuJoCo, and every file that is read.

    Args:
        name: the robot.
        file: the URDF; ``package://`` is looked up in the folders above it.

    Raises:
        BelvedereError: it is an unexpanded xacro, or a mesh is missing or of a kind that MuJoCo cannot read.
    """
    root = read_xml(name, file)
    if b"<xacro:" in file.read_bytes():
        raise BelvedereError(
            f"robot {name}: {file.name} is a xacro, of which MuJoCo would make an empty model; expand it "
            f"first (`xacro {file.name} > expanded.urdf`)."
        )
    meshes = []
    for mesh in root.iter("mesh"):
        place = _mesh(name, file, mesh.get("filename", ""))
        mesh.set("filename", str(place))
        meshes.append(place)
    extension = root.find("mujoco")
    extension = ElementTree.SubElement(root, "mujoco") if extension is None else extension
    compiler = extension.find("compiler")
    compiler = ElementTree.SubElement(extension, "compiler") if compiler is None else compiler
    compiler.attrib |= _COMPILER
    return ElementTree.tostring(root, encoding="unicode"), list(dict.fromkeys([file, *meshes]))


def _mesh(name: str, file: Path, given: str) -> Path:
    """Where a mesh lies that the URDF names by a path from its own folder, file:// or package://."""
    if Path(given).suffix.lower() not in _READ:
        raise BelvedereError(
            f"robot {name}: {file.name} names the mesh {given}, which MuJoCo does not read; it takes STL, "
            "OBJ and MSH: convert the mesh, and name the new file in the URDF."
        )
    if not given.startswith(_PACKAGE):
        place = (file.parent / given.removeprefix("file://")).resolve()
        require(place, f"robot {name}: mesh {given}, which {file.name} names,")
        return place
    inside = given.removeprefix(_PACKAGE)
    found = [above / inside for above in file.resolve().parents if (above / inside).is_file()]
    if not found:
        package = inside.partition("/")[0]
        raise BelvedereError(
            f"robot {name}: mesh {given}, which {file.name} names, is missing: none of the folders above "
            f"{file.name} holds {inside}; copy the ROS package {package} beside the URDF's folder, with its "
            "own folders as they are."
        )
    return found[0]
