"""Trials of the scripted operator in a batch of worlds, as fast as they can be computed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.contract.viewpoints import Viewpoint
from pipeline.scripted.law import ScriptedOperator
from pipeline.scripted.params import OperatorParams
from pipeline.scripted.sight import look_error
from pipeline.sim.draws import Episodes
from pipeline.sim.expert import Expert
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds


@dataclass(frozen=True, eq=False)
class Trials:
    """What n trials came to.

    Attributes:
        grasped: who closed the gripper before the limit: (n,).
        time_s: from the first motion to that; the limit where there was none.
        distance_m: the task's distance at that moment; at the end where there was none.
        look_m: what the view adds to a look, root of the mean square over trials and frames, on each
            controlled axis: (axes,).
    """

    grasped: np.ndarray
    time_s: np.ndarray
    distance_m: np.ndarray
    look_m: np.ndarray


def run_trials(
    scene: Scene,
    view: Viewpoint,
    params: OperatorParams,
    episodes: Episodes,
    rng: np.random.Generator,
    threads: int,
) -> Trials:
    """One trial for each episode, whose looks err as the view has it."""
    worlds, expert, axes = Worlds(scene, len(episodes), threads), Expert(scene), list(scene.axes)
    worlds.reset(episodes)
    frame_s = scene.params.substeps * scene.params.timestep_s
    operator = ScriptedOperator(params, frame_s, len(episodes), len(axes), rng)
    grasped = np.zeros(len(episodes), bool)
    time_s, distance_m = np.full(len(episodes), params.limit_s), worlds.error
    moving, variances = 0, []
    for _ in range(int(params.limit_s / frame_s) + round(params.reaction_s / frame_s)):
        state = worlds.state
        errors = look_error(scene, view, params, state.tip_m, state.target_m)
        variances.append((errors**2).sum(axis=2).mean(axis=0))
        left = -scene.task.gap(state.point_m, state.target_m)[:, axes]
        act = operator.act((expert.waypoint(state) - state.tip_m)[:, axes], left, errors)
        now = act.grasps & ~grasped
        time_s[now] = moving * frame_s
        grasped |= act.grasps
        distance_m = np.where(now | ~grasped, worlds.error, distance_m)
        if grasped.all():
            break
        moving += bool(moving or act.velocity_m_s.any())
        worlds.step(act.velocity_m_s * frame_s / scene.params.displacement_m)
    return Trials(grasped, time_s, distance_m, np.sqrt(np.mean(variances, axis=0)))
