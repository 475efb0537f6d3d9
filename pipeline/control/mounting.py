"""What a controller loses when its camera stands off: turned by degrees, or moved by centimetres.

Nothing is trained: the world model and its controller know the place they were trained at, and look from one
near by.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.contract.machine import cores
from pipeline.contract.progress import Progress
from pipeline.contract.viewpoints import Viewpoint
from pipeline.control.jobs import Job, Networks
from pipeline.control.loops import closed_loops
from pipeline.control.params import MountingParams
from pipeline.learning.device import Compute
from pipeline.sim.camera import camera_to_world
from pipeline.sim.draws import Episodes
from pipeline.sim.scene import Scene


@dataclass(frozen=True)
class Offset:
    """How a camera stands off.

    Attributes:
        theta_deg, phi_deg: by how much it is turned about the scene, still looking at its middle.
        right_m, up_m, back_m: by how much it is moved without being turned, along the picture's right and up
            and away from the scene.
    """

    theta_deg: float = 0.0
    phi_deg: float = 0.0
    right_m: float = 0.0
    up_m: float = 0.0
    back_m: float = 0.0

    @property
    def turn_deg(self) -> float:
        """The larger of both turns; 0 for a move."""
        return max(abs(self.theta_deg), abs(self.phi_deg))

    @property
    def move_m(self) -> float:
        """How far it is moved; 0 for a turn."""
        return float(np.linalg.norm([self.right_m, self.up_m, self.back_m]))


def offsets(declared: MountingParams) -> Iterator[Offset]:
    """None at all, then each declared turn and move, both ways on each axis."""
    yield Offset()
    for turn in declared.turns_deg:
        for sign in (-turn, turn):
            yield Offset(theta_deg=sign)
            yield Offset(phi_deg=sign)
    for move in declared.moves_m:
        for sign in (-move, move):
            yield from (Offset(right_m=sign), Offset(up_m=sign), Offset(back_m=sign))


def standing_off(scene: Scene, view: Viewpoint, off: Offset) -> tuple[Scene, Viewpoint]:
    """The scene and the viewpoint with the camera at the offset."""
    turned = Viewpoint(scene=view.scene, theta=view.theta + off.theta_deg, phi=view.phi + off.phi_deg)
    if not off.move_m:
        return scene, turned
    _, rotation = camera_to_world(scene.params.camera, view)
    moved = np.asarray(scene.params.camera.look_at_m) + rotation @ [off.right_m, off.up_m, off.back_m]
    camera = scene.params.camera.model_copy(update={"look_at_m": tuple(map(float, moved))})
    return replace(scene, params=scene.params.model_copy(update={"camera": camera})), turned


def returns_standing_off(
    scene: Scene,
    view: Viewpoint,
    networks: Sequence[Networks],
    controllers: Sequence[np.ndarray],
    episodes: Sequence[Episodes],
    declared: MountingParams,
    place: Compute,
) -> list[tuple[Offset, np.ndarray]]:
    """Of each offset (repeat,) the mean returns, m, on the same episodes.

    Args:
        scene: compiled.
        view: at which everything was trained.
        networks: the world model of each repeat.
        controllers: flat weights, one of each repeat.
        episodes: of each repeat.
        declared: which offsets; those that would tilt the camera over the zenith are left out.
        place: where the networks compute.
    """
    found, every = [], [off for off in offsets(declared) if abs(view.phi + off.phi_deg) < 90]
    pairs = enumerate(zip(controllers, episodes, strict=True))
    jobs = [Job.of(member, flat[None], own) for member, (flat, own) in pairs]
    with Progress(len(every), f"mounting {scene.name} ({view.theta:g}°, {view.phi:g}°)") as progress:
        for off in every:
            loops = closed_loops(*standing_off(scene, view, off), networks, place.device, cores())
            found.append((off, np.array([trace.returns.mean() for trace in loops.run(jobs)])))
            progress.advance(returned=f"{found[-1][1].mean():.2f}")
    return found
