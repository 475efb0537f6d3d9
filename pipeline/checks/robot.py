"""`python -m pipeline.checks.robot`: what a declared robot can do, in numbers and seen from six sides."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.contract import params, seeds
from pipeline.contract.errors import BelvedereError
from pipeline.rendering.six_sides import drawn_faces, milliseconds_a_picture, write_six_sides
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.expert import Expert
from pipeline.sim.params import Camera, Light, Range, SceneParams, Start, Target
from pipeline.sim.reach import reachable_box
from pipeline.sim.robot import arm_actuators
from pipeline.sim.robot_params import RobotParams, robot_params
from pipeline.sim.scene import Scene, compile_scene, initial_data
from pipeline.sim.worlds import Worlds
from pipeline.storage.stage import entry

_EPISODES = 32
_PUSHED = 4  # frames at full push, of which the last is measured
_ROOM = 0.7  # share of the reachable box, about its middle, that targets and starts take
_FACES = 200_000  # above which a picture is slow for no gain at 64 × 64


def main(*, robot: str, out: Path) -> None:
    """Prints what the robot of params.yaml is and does, and writes its picture to ``out``."""
    declared = robot_params(robot)
    scene = alone(robot, declared)
    _tell_parts(scene)
    low, high = reachable_box(scene)
    print(f"reachable box:   {_place(low)} to {_place(high)} m, about the tip at home")
    trial = _within(scene, low, high)
    _tell_motion(trial)
    write_six_sides(trial, out)
    faces = drawn_faces(trial.model)
    slow = "; fewer faces draw faster (see docs/robots.md)" if faces > _FACES else ""
    print(f"a picture:       {milliseconds_a_picture(trial):.2f} ms at 64 × 64, of {faces} faces{slow}")
    print(f"wrote {out}: from θ = 0°, 45°, 90°, 180° and 270°, and from above")


def alone(name: str, declared: RobotParams) -> Scene:
    """The robot by itself, in a scene about its tip at home.

    Raises:
        BelvedereError: it has no arm whose joints inverse kinematics turn.
    """
    if declared.drive.actuators == "weld":
        raise BelvedereError(
            f"robot {name} is pulled by a weld and has no home to reach from; look at a scene of it instead: "
            "`./run python -m pipeline.rendering.preview --help`."
        )
    first = compile_scene(name, _scene(name, np.zeros(3), np.ones(3)), declared, Path())
    tip = initial_data(first).site_xpos[first.tip_site]
    return compile_scene(name, _scene(name, tip - 0.1, tip + 0.1), declared, Path())


def _scene(name: str, low: np.ndarray, high: np.ndarray) -> SceneParams:
    """Reaching within a box from anywhere in it, on all three axes."""
    ends = {"low_m": tuple(low.tolist()), "high_m": tuple(high.tolist())}
    middle, half = (low + high) / 2, (high - low) / 2
    return SceneParams(
        robot=name,
        desk=None,
        axes=("x", "y", "z"),
        frames=50,
        substeps=20,
        timestep_s=0.002,
        displacement_m=0.05,
        workspace=Range(**ends),
        start=Start(**ends, above_target_m=None),
        target=Target(candidates_m=(tuple(middle),), jitter_m=tuple(half), radius_m=0.03),
        obstacles=(),
        obstacle_clearance_m=0.0,
        camera=Camera(look_at_m=tuple(middle), distance_m=1.0, fov_deg=40, front_deg=0),
        light=Light(ambient=0.35, above=0.35, camera=0.45, background_rgb=(0.35, 0.42, 0.5)),
    )


def _within(scene: Scene, low: np.ndarray, high: np.ndarray) -> Scene:
    middle, half = (low + high) / 2, _ROOM * (high - low) / 2
    described = _scene(scene.robot.name, middle - half, middle + half)
    return compile_scene(scene.name, described, scene.declared, Path())


def _place(point: np.ndarray) -> str:
    return "[" + ", ".join(f"{value:.2f}" for value in point) + "]"


def _tell_parts(scene: Scene) -> None:
    robot, model = scene.robot, scene.model
    arm = arm_actuators(model, robot) if robot.control == "joints" else ()
    others = [model.actuator(a).name.removeprefix(robot.prefix) for a in range(model.nu) if a not in arm]
    print(f"robot:           {robot.name}, {scene.declared.file}, {len(robot.files)} files")
    print(f"arm's joints:    {', '.join(j.removeprefix(robot.prefix) for j in robot.arm)}")
    print(f"tip at home:     {_place(initial_data(scene).site_xpos[scene.tip_site])} m")
    print(
        f"actuators:       {scene.declared.drive.actuators}, {len(arm)} of the arm; held: "
        f"{', '.join(others) or 'none'}"
    )
    print(f"left out:        {', '.join(robot.dropped) or 'nothing'}")


def _tell_motion(scene: Scene) -> None:
    worlds = Worlds(scene, _EPISODES)
    episodes = draw_episodes(scene, _EPISODES, seeds.generator(params.seed(), 0, seeds.Stream.ROLLOUTS))
    expert, returns = Expert(scene), np.zeros(_EPISODES)
    worlds.reset(episodes)
    for _ in range(scene.frames):
        returns += worlds.step(expert(worlds.state))
    missed = np.linalg.norm(worlds.tip - worlds.target, axis=1).max()
    worlds.reset(episodes)
    for _ in range(scene.frames):
        worlds.step(np.zeros((_EPISODES, 3)))
    sunk = np.linalg.norm(worlds.tip - episodes.start_m, axis=1).max()
    print(f"full push:       {_speed(scene)} mm a frame")
    print(
        f"expert:          return {returns.mean():.2f}; its largest miss at the end is {1000 * missed:.1f} mm"
    )
    print(f"standing still:  drifts {1000 * sunk:.1f} mm in an episode")


def _speed(scene: Scene) -> str:
    """How far the tip goes in a frame at full push each way along each axis, from the box's middle."""
    pushes = np.concatenate([np.eye(3), -np.eye(3)])
    start = np.repeat(np.asarray(scene.params.target.candidates_m), len(pushes), axis=0)
    worlds = Worlds(scene, len(pushes))
    worlds.reset(Episodes.at(start, start))
    for _ in range(_PUSHED):
        before = worlds.tip
        worlds.step(pushes)
    steps = 1000 * np.linalg.norm(worlds.tip - before, axis=1)
    return f"{steps.min():.0f} to {steps.max():.0f}"


if __name__ == "__main__":
    entry(main)
