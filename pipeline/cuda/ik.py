"""Inverse kinematics as a Warp kernel: :class:`pipeline.sim.arm_controllers.JointController` on the CPU."""

# mypy: disable-error-code="misc, index, valid-type, operator"
# (a kernel is no Python: its values have other types inside than outside)

from __future__ import annotations

import mujoco
import mujoco_warp as mjw
import warp as wp

from pipeline.sim.arm_controllers import DAMPING, NEWTON_STEPS
from pipeline.sim.robot import joint_ranges
from pipeline.sim.scene import Scene, initial_data

wp.set_module_options({"enable_backward": False})

# Near a stretched arm the damping is less than what float32 leaves of the matrix: it is float64's to solve.
_Vector = wp.types.vector(6, wp.float64)
_Matrix = wp.types.matrix((6, 6), wp.float64)


@wp.struct
class Arm:
    """The joints that inverse kinematics turns, and the pose that it keeps."""

    joints: wp.array[int]
    coordinates: wp.array[int]  # of the joints in qpos
    moves: wp.array[int]  # 0: not the tip; 1: slides it; 2: turns it
    low: wp.array[float]
    high: wp.array[float]
    site: int
    upright: wp.mat33
    damping: wp.float64
    keeps_pose: bool
    most: float  # of a joint in one step, rad or m


def arm(scene: Scene) -> Arm:
    """The scene's arm, on Warp's current device."""
    model = scene.model
    joints = [model.joint(name).id for name in scene.robot.arm]
    carriers = _carriers(model, int(model.site_bodyid[scene.tip_site]))
    turning = int(mujoco.mjtJoint.mjJNT_HINGE)
    made = Arm()
    made.joints = wp.array(joints, dtype=int)
    made.coordinates = wp.array(model.jnt_qposadr[joints], dtype=int)
    kinds = [1 + int(model.jnt_type[j] == turning) if model.jnt_bodyid[j] in carriers else 0 for j in joints]
    made.moves = wp.array(kinds, dtype=int)
    made.low, made.high = (wp.array(ends, dtype=float) for ends in joint_ranges(model, scene.robot.arm))
    made.site = scene.tip_site
    made.upright = wp.mat33(*initial_data(scene).site_xmat[scene.tip_site])
    made.damping = wp.float64(DAMPING**2)
    made.keeps_pose = scene.robot.keeps_pose
    made.most = scene.declared.drive.largest_step / NEWTON_STEPS
    return made


def _carriers(model: mujoco.MjModel, body: int) -> set[int]:
    """The body and those that carry it."""
    found = set()
    while body > 0:
        found.add(body)
        body = int(model.body_parentid[body])
    return found


def newton(model: mjw.Model, ik_state: mjw.Data, joints: Arm, setpoint: wp.array) -> None:
    """One step of every world's ik_state towards its setpoint tip place (n,), m."""
    mjw.kinematics(model, ik_state)
    wp.launch(
        newton_step,
        dim=len(setpoint),
        inputs=[joints, setpoint, ik_state.site_xpos, ik_state.site_xmat, ik_state.xanchor, ik_state.xaxis],
        outputs=[ik_state.qpos],
    )


@wp.func
def _column(arm: Arm, joint: int, place: wp.vec3, anchor: wp.vec3, axis: wp.vec3) -> _Vector:
    """What a joint's unit of motion does to the tip: its place, and its rotation."""
    column = _Vector()
    along, about = wp.vec3(0.0), wp.vec3(0.0)
    if arm.moves[joint] == 1:
        along = axis
    elif arm.moves[joint] == 2:
        along = wp.cross(axis, place - anchor)
        about = axis
    if not arm.keeps_pose:  # the rows of the rotation are nought, so that they move nothing
        about = wp.vec3(0.0)
    for k in range(3):
        column[k] = wp.float64(along[k])
        column[k + 3] = wp.float64(about[k])
    return column


@wp.func
def _missing(setpoint: wp.vec3, place: wp.vec3, rotation: wp.mat33, upright: wp.mat33) -> _Vector:
    """The way to the setpoint place, and the rotation to the upright pose as a vector."""
    missing = _Vector()
    tilt = wp.vec3(0.0)
    for k in range(3):  # half the sum of cross products of matching axes
        now = wp.vec3(rotation[0, k], rotation[1, k], rotation[2, k])
        then = wp.vec3(upright[0, k], upright[1, k], upright[2, k])
        tilt += 0.5 * wp.cross(now, then)
    for k in range(3):
        missing[k] = wp.float64(setpoint[k]) - wp.float64(place[k])
        missing[k + 3] = wp.float64(tilt[k])
    return missing


@wp.func
def solved(gram: _Matrix, right: _Vector) -> _Vector:
    """Solves a symmetric, positive definite system by Cholesky's factors."""
    lower = _Matrix()
    for i in range(6):
        for j in range(i + 1):
            rest = gram[i, j]
            for k in range(j):
                rest -= lower[i, k] * lower[j, k]
            if i == j:
                lower[i, i] = wp.sqrt(rest)
            else:
                lower[i, j] = rest / lower[j, j]
    found = _Vector()
    for i in range(6):
        rest = right[i]
        for k in range(i):
            rest -= lower[i, k] * found[k]
        found[i] = rest / lower[i, i]
    for back in range(6):
        i = 5 - back
        rest = found[i]
        for k in range(i + 1, 6):
            rest -= lower[k, i] * found[k]
        found[i] = rest / lower[i, i]
    return found


@wp.kernel
def newton_step(
    arm: Arm,
    setpoint: wp.array[wp.vec3],
    site_place: wp.array2d[wp.vec3],
    site_turn: wp.array2d[wp.mat33],
    anchor: wp.array2d[wp.vec3],
    axis: wp.array2d[wp.vec3],
    qpos: wp.array2d[float],
) -> None:
    """One damped least-squares step of one world's joints, kept within their ranges."""
    world = wp.tid()
    place = site_place[world, arm.site]
    gram = _Matrix()
    for k in range(6):
        gram[k, k] = arm.damping
    for index in range(arm.joints.shape[0]):
        joint = arm.joints[index]
        column = _column(arm, index, place, anchor[world, joint], axis[world, joint])
        gram += wp.outer(column, column)
    way = solved(gram, _missing(setpoint[world], place, site_turn[world, arm.site], arm.upright))
    largest = arm.most
    for index in range(arm.joints.shape[0]):
        joint = arm.joints[index]
        column = _column(arm, index, place, anchor[world, joint], axis[world, joint])
        largest = wp.max(largest, wp.abs(float(wp.dot(column, way))))
    for index in range(arm.joints.shape[0]):
        joint = arm.joints[index]
        column = _column(arm, index, place, anchor[world, joint], axis[world, joint])
        at = arm.coordinates[index]
        moved = qpos[world, at] + float(wp.dot(column, way)) * (arm.most / largest)
        qpos[world, at] = wp.clamp(moved, arm.low[index], arm.high[index])
