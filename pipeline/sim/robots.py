"""The robots that params.yaml declares, as MuJoCo model specs to which a scene adds its own things."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import mujoco

from pipeline.sim.attached import attached
from pipeline.sim.robot import Robot
from pipeline.sim.robot_files import robot_file, unreadable
from pipeline.sim.robot_params import RobotParams
from pipeline.sim.wheel_robots import fetch_reach, kitchen_panda

Builder = Callable[[str, RobotParams, Path], tuple[mujoco.MjSpec, Robot]]
BUILDERS: dict[str, Builder] = {
    "attached": attached,
    "kitchen_panda": kitchen_panda,
    "fetch_reach": fetch_reach,
}


def build_robot(name: str, declared: RobotParams, root: Path) -> tuple[mujoco.MjSpec, Robot]:
    """A spec with the robot and its site :data:`pipeline.sim.robot.TIP`, and how it is moved.

    Args:
        name: the robot's name in params.yaml.
        declared: what params.yaml says of it.
        root: the repository's root.

    Raises:
        BelvedereError: the file is missing, or does not fit the declaration.
    """
    file = robot_file(name, declared.file, root)
    try:
        return BUILDERS[declared.build](name, declared, file)
    except ValueError as error:
        raise unreadable(name, file, error) from None


def limit_contacts(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Leaves, in a whole scene, only contacts of the robot's ``touching`` bodies with what is not the robot.

    A robot that keeps its tip in a workspace does not touch itself; looking whether it does costs time
    in every substep.
    """
    for geom in spec.geoms:
        if not geom.contype and not geom.conaffinity:
            continue
        name = geom.parent.name
        geom.contype = int(name in robot.touching)
        geom.conaffinity = int(not name.startswith(robot.prefix))
