"""`python -m pipeline.checks.home`: a home posture for a robot of which none is known, as YAML."""

from __future__ import annotations

from pipeline.checks.robot import alone
from pipeline.contract import params, seeds
from pipeline.sim.reach import search_home
from pipeline.sim.robot_params import robot_params
from pipeline.storage.stage import entry


def main(*, robot: str) -> None:
    """Prints the line ``home: …`` for a robot of params.yaml; the one that it has plays no part."""
    declared = robot_params(robot)
    scene = alone(robot, declared.model_copy(update={"home": {}}))
    posture = search_home(scene, seeds.generator(params.seed(), 0, seeds.Stream.ROLLOUTS))
    print("    home: {" + ", ".join(f"{joint}: {position:.2f}" for joint, position in posture.items()) + "}")


if __name__ == "__main__":
    entry(main)
