"""A batch of worlds that stays on one device, pictures included; mujoco_warp steps it.

Meant for CUDA. It runs on Warp's CPU backend too, where MuJoCo's own :mod:`pipeline.sim.worlds` is faster and
in float64: that is how it is tested where there is no GPU.
"""

# mypy: disable-error-code="misc, index"
# (a kernel is no Python: its values have other types inside than outside)

from __future__ import annotations

import mujoco_warp as mjw
import numpy as np
import warp as wp
from mujoco_warp import OverflowType

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.cuda.arm_controllers import Setpoints, device_arm_controller
from pipeline.rendering.renderer import Renderer, warp_model
from pipeline.sim.arm_controllers import Fields, arm_controller
from pipeline.sim.draws import Episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import not_a_number, start_fields, target_paths

wp.set_module_options({"enable_backward": False})

_CONTACTS = 48  # room for so many a world, which worlds share; a world of the scenes has up to 16
_CONSTRAINTS = 384  # room for so many in each; a hand that leans on the obstacle makes up to 160
# What :meth:`DeviceWorlds.check` refuses. The mask's other bits say that a solver was cut off at its limit
# of iterations, which MuJoCo only warns of, or are of things that the scenes lack.
_NO_ROOM = OverflowType.NEFC | OverflowType.NJMAX_NNZ | OverflowType.BROADPHASE
_NO_ROOM |= OverflowType.NARROWPHASE | OverflowType.CCD


@wp.kernel
def move_targets(
    path: wp.array2d[wp.vec3],
    frame: wp.array[int],
    mocap: int,
    target: wp.array[wp.vec3],
    mocap_place: wp.array2d[wp.vec3],
) -> None:
    """Takes the targets, and the bodies that stand for them, to where they are after so many frames."""
    world = wp.tid()
    place = path[wp.min(frame[0], path.shape[0] - 1), world]
    target[world] = place
    mocap_place[world, mocap] = place


@wp.kernel
def count(frame: wp.array[int]) -> None:
    """Counts a frame."""
    frame[0] = frame[0] + 1


@wp.kernel
def measure(
    places: wp.array2d[wp.vec3],
    tip_site: int,
    point_site: int,
    target: wp.array[wp.vec3],
    offset: wp.vec3,
    counted: wp.vec3,
    tip: wp.array[wp.vec3],
    error: wp.array[float],
    reward: wp.array[float],
) -> None:
    """Tips, and how far from the targets is what shall come there; minus that is paper eq. (1)."""
    world = wp.tid()
    tip[world] = places[world, tip_site]
    gap = places[world, point_site] - (target[world] + offset)
    error[world] = wp.length(wp.cw_mul(gap, counted))
    reward[world] = -error[world]


class DeviceWorlds:
    """``count`` worlds and their pictures from one viewpoint; nothing goes to the host in a step.

    A step is a graph of some thousand kernels, captured once and launched as one, on CUDA as on the CPU.

    Args:
        scene: the compiled scene.
        view: where the camera stands.
        count: how many worlds.
        device: where Warp computes.

    Attributes (all on the device, always the same memory, so that others may share it):
        action: to be filled in before each step, (count, action_size), float32, shares of the largest
            displacement in [-1, 1].
        rgb: pictures of the worlds as they stand, (count, 64, 64, 3), uint8.
        tip: (count,) of three, m.
        target: likewise.
        qpos: generalised positions, (count, nq), float32.
        reward: of the last step, paper eq. (1), (count,), float32, m.
        error: what the reward counts, as the worlds stand, likewise.
    """

    def __init__(self, scene: Scene, view: Viewpoint, count: int, device: wp.DeviceLike) -> None:
        self._images = Renderer(scene, view, count, device=device)
        self.scene, self.count, self.device = scene, count, wp.get_device(device)
        with wp.ScopedDevice(self.device):
            self._model = warp_model(scene, scene.model)
            self._model.opt.graph_conditional = self.device.is_cpu or wp.is_conditional_graph_supported()
            self._model.opt.warn_overflow = 0  # :meth:`check` tells it once
            room = {"nconmax": _CONTACTS, "njmax": _CONSTRAINTS}
            self._data = mjw.make_data(scene.model, nworld=count, **room)
            self._setpoints, self._arm_controller = (
                Setpoints(scene, count),
                device_arm_controller(scene, self._model, count),
            )
            self.action = wp.zeros((count, scene.action_size), dtype=float)
            self.tip, self.target = wp.zeros(count, dtype=wp.vec3), wp.zeros(count, dtype=wp.vec3)
            self.reward, self.error = wp.zeros(count, dtype=float), wp.zeros(count, dtype=float)
            self._path = wp.zeros((scene.frames + 1, count), dtype=wp.vec3)
            self._frames_done = wp.zeros(1, dtype=int)
            self.qpos = self._data.qpos
            mjw.kinematics(self._model, self._data)
            self.rgb = self._look()
            self._graph = self._captured()

    def reset(self, episodes: Episodes) -> None:
        """Starts one episode per world.

        Raises:
            BelvedereError: the robot cannot bring its tip to a start.
        """
        if len(episodes) != self.count:
            raise ValueError(f"{len(episodes)} episodes for {self.count} worlds")
        fields = fields_at_start(self.scene, episodes)
        with wp.ScopedDevice(self.device):
            mjw.reset_data(self._model, self._data)
            for left in (self._data.cvel, self._data.cdof_dot):  # a weld reads those of the step before
                left.zero_()
            for name, values in fields.items():
                _upload(getattr(self._data, name), values)
            _upload(self._path, target_paths(self.scene, episodes).swapaxes(0, 1))
            self._frames_done.zero_()
            self._move_targets()
            _upload(self._setpoints.start, episodes.start_m)
            self._setpoints.refused.zero_()
            self._arm_controller.reset(fields)
            mjw.kinematics(self._model, self._data)
            self._look()

    def step(self) -> None:
        """Moves every world one frame on, by :attr:`action`, and draws it."""
        with wp.ScopedDevice(self.device):
            wp.capture_launch(self._graph)

    def check(self) -> None:
        """Looks, at the end of an episode, whether anything went wrong in it; waits for the device.

        Raises:
            BelvedereError: an action was not a number, or there was no room for all contacts.
        """
        if self._setpoints.refused.numpy()[0]:
            raise not_a_number(self.scene)
        if (self._data.overflow.numpy() & int(_NO_ROOM)).any():
            raise BelvedereError(
                f"scene {self.scene.name}: too much touches at a time: worlds on a device have room for "
                f"{_CONTACTS} contacts each, all in all, and {_CONSTRAINTS} constraints each; simplify the "
                "scene, or use BELVEDERE_DEVICE=cpu."
            )

    def _captured(self) -> wp.Graph:
        """A frame as a graph of kernels; a first frame loads them, which a capture may not be able to."""
        self._frame()
        with wp.ScopedCapture(device=self.device, force_module_load=False) as capture:
            self._frame()
        return capture.graph

    def _frame(self) -> None:
        setpoint = self._setpoints.make(self.action, self.tip)
        self._arm_controller.move(self._data, self.tip, setpoint)
        wp.launch(count, dim=1, inputs=[self._frames_done])
        self._move_targets()
        for _ in range(self.scene.params.substeps):
            mjw.step(self._model, self._data)
        mjw.kinematics(self._model, self._data)  # a step leaves poses one behind the state
        self._look()

    def _move_targets(self) -> None:
        wp.launch(
            move_targets,
            dim=self.count,
            inputs=[self._path, self._frames_done, self.scene.target_mocap],
            outputs=[self.target, self._data.mocap_pos],
        )

    def _look(self) -> wp.array:
        scene, task = self.scene, self.scene.task
        sites, weights = [scene.tip_site, scene.point_site], [wp.vec3(*task.offset_m), wp.vec3(*task.counted)]
        wp.launch(
            measure,
            dim=self.count,
            inputs=[self._data.site_xpos, *sites, self.target, *weights],
            outputs=[self.tip, self.error, self.reward],
        )
        return self._images.draw(self._data, self.count)


def fields_at_start(scene: Scene, episodes: Episodes) -> Fields:
    """The state in which each episode starts; those that begin alike, as candidates' do, are solved once."""
    all_of_it = np.concatenate([episodes.start_m, episodes.target_m, episodes.drawn], axis=1)
    _, first, where = np.unique(all_of_it, axis=0, return_index=True, return_inverse=True)
    unlike = episodes[first]
    fields = start_fields(scene, arm_controller(scene, len(unlike), 1), unlike)
    return {name: values[where.reshape(-1)] for name, values in fields.items()}


def _upload(array: wp.array, values: np.ndarray) -> None:
    """Copies values with a leading axis over worlds into an array on a device."""
    array.assign(np.ascontiguousarray(values, dtype=np.float32))
