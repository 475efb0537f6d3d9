"""OBJ files with several objects, of which MuJoCo would keep one, silently: their objects are joined."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco

_OBJECT = re.compile(rb"(?m)^[og][ \t].*$")  # where a new object or group begins
_FACE = re.compile(rb"(?m)^f[ \t]")


def join_objects(spec: mujoco.MjSpec) -> None:
    """Gives the spec the text of each such file that its meshes name, with its objects made one."""
    folder = Path(spec.modelfiledir, spec.compiler.meshdir)
    joined: dict[str, bytes] = {}
    for number, mesh in enumerate(spec.meshes):
        path = folder / mesh.file  # which may be absolute
        if path.suffix.lower() == ".obj" and _objects(text := path.read_bytes()) > 1:
            mesh.file = f"joined{number}.obj"
            joined[mesh.file] = _OBJECT.sub(b"", text)
    if joined:
        spec.assets = {**spec.assets, **joined}


def _objects(text: bytes) -> int:
    """How many objects of a file have faces."""
    return sum(bool(_FACE.search(part)) for part in _OBJECT.split(text))
