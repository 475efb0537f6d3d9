"""Checks all of params.yaml, so that a slip is told before anything is run or deleted."""

from __future__ import annotations

import re
from collections.abc import Collection
from functools import lru_cache
from pathlib import Path

from pipeline.ablations.params import AblationParams
from pipeline.contract import params
from pipeline.contract.errors import unknown
from pipeline.contract.viewpoints import NAME, named_viewpoints
from pipeline.control.params import ControllerParams, EvaluationSizes, MountingParams, SearchSizes
from pipeline.placement.params import PlacementParams
from pipeline.qlearning.params import DqnParams, DqnSizes
from pipeline.scripted.params import OperatorParams
from pipeline.sim.params import ExplorationParams, RolloutSizes, SceneParams
from pipeline.sim.robot_files import robot_file
from pipeline.sim.robot_params import RobotParams, robot_params
from pipeline.sim.robots import build_robot
from pipeline.station.params import station_params
from pipeline.stats.params import HalvingParams, RankingParams
from pipeline.storage.stage import entry
from pipeline.study.params import PeopleParams
from pipeline.worldmodel.params import MdnRnnParams, MdnRnnSizes, VaeParams, VaeSizes

METHODS: dict[str, type[params.Section]] = {
    "ablation": AblationParams,
    "controller": ControllerParams,
    "dqn": DqnParams,
    "mdnrnn": MdnRnnParams,
    "mounting": MountingParams,
    "operator": OperatorParams,
    "people": PeopleParams,
    "ranking": RankingParams,
    "rollouts": ExplorationParams,
    "vae": VaeParams,
}
SIZES: dict[str, type[params.Section]] = {
    "controller": SearchSizes,
    "dqn": DqnSizes,
    "evaluation": EvaluationSizes,
    "mdnrnn": MdnRnnSizes,
    "race": params.Race,
    "rollouts": RolloutSizes,
    "vae": VaeSizes,
}
DIFFER = ("budgets", "ranking")  # whose values may be others in a scene
OTHERS = (
    "viewpoint",
    "viewpoints",
    "budget",
    "budgets",
    "seed",
    "heldout_share",
    "sight_share",
    "robots",
    "scenes",
    "searches",
    "station",
)


def main() -> None:
    """Raises at the first value that is not valid."""
    check()


def check(path: Path = params.PARAMS_FILE) -> None:
    """Reads every section as the stages do, for every budget and scene.

    Raises:
        BelvedereError: a value is missing, unknown, of a wrong type or out of its range.
    """
    _known(params.mapping(path=path), {*METHODS, *OTHERS}, "at the top level", path)
    params.budget(path), params.seed(path), params.heldout_share(path), params.sight_share(path)
    _robots(path)
    scenes = _scenes(path)
    for key, view in named_viewpoints(path).items():
        if view.scene not in scenes:
            raise unknown(f"{path}: scene of viewpoint {key}", view.scene, scenes)
    for name, model in METHODS.items():
        _section(model, (name,), scenes, path)
    station_params(path)
    _searches(scenes, path)
    for scene in params.section(DqnParams, "dqn", path=path).scenes:
        if scene not in scenes:
            raise unknown(f"{path}: scene below dqn.scenes", scene, scenes)
    for budget in params.mapping("budgets", path=path):
        _budget(budget, scenes, path)


def _scenes(path: Path) -> dict[str, SceneParams]:
    found = {}
    for name in params.mapping("scenes", path=path):
        if not re.fullmatch(NAME, str(name)):
            raise params.invalid(path, "a name below scenes", name, "it has letters, digits, _ and -")
        found[name] = params.section(SceneParams, "scenes", name, path=path)
        robot_params(found[name].robot, path)
    return found


def _searches(scenes: dict[str, SceneParams], path: Path) -> None:
    for scene in params.mapping("searches", path=path):
        if scene not in scenes:
            raise unknown(f"{path}: scene below searches", scene, scenes)
        where = ("searches", scene)
        _known(params.mapping(*where, path=path), {"placement", "procedure"}, f"below searches.{scene}", path)
        params.section(PlacementParams, *where, "placement", path=path)
        params.section(HalvingParams, *where, "procedure", path=path)


def _robots(path: Path) -> None:
    for name in params.mapping("robots", path=path):
        if not re.fullmatch(NAME, str(name)):
            raise params.invalid(path, "a name below robots", name, "it has letters, digits, _ and -")
        declared = robot_params(name, path)
        changed = robot_file(name, declared.file, path.parent).stat().st_mtime_ns
        _build(name, declared.model_dump_json(exclude_unset=True), path.parent, changed)


@lru_cache(maxsize=64)
def _build(name: str, declared: str, root: Path, changed_ns: int) -> None:
    """Reads the robot's files as a scene does; what was right once is right until the file changes."""
    build_robot(name, RobotParams.model_validate_json(declared), root)


def _budget(name: str, scenes: dict[str, SceneParams], path: Path) -> None:
    place = ("budgets", name)
    given = params.mapping(*place, path=path)
    _known(given, {*SIZES, "about"}, f"below budgets.{name}", path)
    if not isinstance(params.value(*place, "about", path=path), str):
        raise params.invalid(path, f"budgets.{name}.about", given["about"], "it is a text")
    for noun, model in SIZES.items():
        _section(model, (*place, noun), scenes, path)
    for scene, described in scenes.items():
        sizes = params.scene_section(VaeSizes, *place, "vae", scene=scene, path=path)
        if sizes.frame_stride > described.frames:
            why = f"an episode of {scene} has {described.frames} frames"
            raise params.invalid(path, f"budgets.{name}.vae.frame_stride", sizes.frame_stride, why)


def _section(model: type[params.Section], keys: tuple[str, ...], scenes: Collection[str], path: Path) -> None:
    """The section as each scene has it."""
    given = params.mapping(*keys, path=path)
    if keys[0] not in DIFFER or "scenes" not in given:
        params.section(model, *keys, path=path)
        return
    own = ".".join([*keys, "scenes"])
    _known(params.mapping(*keys, "scenes", path=path), scenes, f"below {own}", path)
    for scene in scenes:
        params.scene_section(model, *keys, scene=scene, path=path)


def _known(given: Collection[str], valid: Collection[str], where: str, path: Path) -> None:
    for name in given:
        if name not in valid:
            raise unknown(f"{path}: key {where}", name, valid)


if __name__ == "__main__":
    entry(main)
