"""Writes down what a scene is made of: its declaration, its robot's, a hash of each of the robot's files."""

from __future__ import annotations

from pathlib import Path

from pipeline.sim.scene import load_scene
from pipeline.storage.artefacts import write_json
from pipeline.storage.stage import entry


def main(*, scene: str, robots: Path, out: Path) -> None:
    """Compiles the scene and writes the facts that decide it.

    The stages that compile a scene depend on ``out``, so that a changed mesh of a robot invalidates its own
    scenes and no others. ``robots`` is the folder in which the repository's robots lie.
    """
    write_json(out, {"name": scene, **load_scene(scene, root=robots.parent).cache_key})


if __name__ == "__main__":
    entry(main)
