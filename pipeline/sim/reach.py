"""How far an arm reaches about its home posture, and a posture for those who know none."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from pipeline.contract.errors import BelvedereError
from pipeline.sim.arm_controllers import TOLERANCE_M, JointController
from pipeline.sim.robot import joint_ranges
from pipeline.sim.scene import Scene, initial_data

_GRID = np.array(
    list(itertools.product((0.0, 0.5, 1.0), repeat=3))
)  # of a box: corners, edges, faces, middle
_STEP_M = 0.05
_FARTHEST_M = 0.3  # from the tip at home, along an axis
_ABOVE_BASE_M = 0.03  # what a desk at the base's height leaves free
_POSTURES = 4096
_TURN_RAD = (
    np.pi / 2
)  # postures are drawn within ± this about the middle, where a joint has no narrower range
_LEVER_M = 0.3  # by which turning the tip by a radian is weighed against moving it


def reachable_box(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """A box about the tip at home, all of which the arm reaches from there: low and high (3,), m.

    It is grown side by side; a side stops where inverse kinematics do not reach a grid of 27 points.
    """
    ik = JointController(scene, len(_GRID), 1)
    tip = initial_data(scene).site_xpos[scene.tip_site].copy()
    floor = scene.declared.base.position_m[2] + _ABOVE_BASE_M
    low, high = tip.copy(), tip.copy()
    growing = list(itertools.product((0, 1, 2), (-1, 1)))
    while growing:
        for axis, side in list(growing):
            wider_low, wider_high = low.copy(), high.copy()
            (wider_low if side < 0 else wider_high)[axis] += side * _STEP_M
            far = (
                max(abs(wider_low[axis] - tip[axis]), abs(wider_high[axis] - tip[axis])) > _FARTHEST_M + 1e-9
            )
            points = wider_low + _GRID * (wider_high - wider_low)
            if far or wider_low[2] < floor or ik.solve(points).max() > TOLERANCE_M:
                growing.remove((axis, side))
            else:
                low, high = wider_low, wider_high
    return low, high


def search_home(scene: Scene, rng: np.random.Generator) -> dict[str, float]:
    """A posture far from singular ones and from the ends of joints' ranges, by the arm's joint, rad or m.

    Drawn postures count whose tip stands in front of the base (x forward) and whose links all stand above it.

    Raises:
        BelvedereError: no drawn posture is such.
    """
    model, arm = scene.model, scene.robot.arm
    low, high = joint_ranges(model, arm)
    middle = np.where(np.isinf(low), 0.0, (np.nan_to_num(low) + np.nan_to_num(high)) / 2)
    low, high = np.maximum(low, middle - _TURN_RAD), np.minimum(high, middle + _TURN_RAD)
    drawn = low + rng.uniform(size=(_POSTURES, len(arm))) * (high - low)
    batch = mujoco_batch.Batch(model, _POSTURES, 1)
    qpos, tips, links = batch.bind("qpos"), batch.bind("site_xpos"), batch.bind("xpos")
    qpos[:] = initial_data(scene).qpos
    qpos[:, [model.joint(name).qposadr[0] for name in arm]] = drawn
    batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS)
    tip = tips[:, scene.tip_site].copy()
    along, about = batch.jac(int(model.site_bodyid[scene.tip_site]), tip)
    rows = [along, _LEVER_M * about] if scene.robot.keeps_pose else [along]
    jacobian = np.concatenate(rows, axis=1)[:, :, [model.joint(name).dofadr[0] for name in arm]]
    room = (np.minimum(drawn - low, high - drawn) / np.maximum(high - low, 1e-9)).min(axis=1)
    score = np.linalg.svd(jacobian, compute_uv=False)[:, -1] * np.minimum(room, 0.1)
    from_base = tip - np.asarray(scene.declared.base.position_m)
    moved = [
        b
        for b in range(model.nbody)
        if model.body_dofnum[b] and model.body(b).name.startswith(scene.robot.prefix)
    ]
    above = (links[:, moved, 2] - scene.declared.base.position_m[2]).min(axis=1) > -1e-6
    lifted = from_base[:, 2] > 0.3 * np.linalg.norm(from_base, axis=1)
    ahead = (from_base[:, 0] > 0) & (np.abs(from_base[:, 1]) < 0.3 * from_base[:, 0])
    score = np.where(above & lifted & ahead, score, 0.0)
    if score.max() <= 0:
        raise BelvedereError(
            f"robot {scene.robot.name}: none of {_POSTURES} drawn postures has its tip in front of the base "
            f"(along x) with all links above it; turn it by robots.{scene.robot.name}.base.turn_deg."
        )
    best = drawn[int(score.argmax())]
    return {name.removeprefix(scene.robot.prefix): float(q) for name, q in zip(arm, best, strict=True)}
