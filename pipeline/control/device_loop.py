"""The closed loop on one device: worlds, pictures, networks and controllers share its memory.

All jobs' worlds are one batch, which is stepped and drawn at once; each job's slice of it goes through
the job's own networks. Nothing goes to the host before the end of the episode. On CUDA, Warp and torch
work on one stream, so each finds what the other has written without waiting for the host.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import torch
import warp as wp
from torch import Tensor

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.control.jobs import Job, Networks
from pipeline.control.loop import Trace
from pipeline.control.policy import Controllers
from pipeline.cuda.worlds import DeviceWorlds
from pipeline.rendering.renderer import start_ray_tracer
from pipeline.sim.draws import Episodes
from pipeline.sim.scene import Scene
from pipeline.worldmodel.mdnrnn import State


class DeviceLoop:
    """Runs controllers in worlds seen from one viewpoint; its worlds are used again by calls of one size.

    Args:
        scene: the compiled scene.
        view: where the camera stands.
        networks: those that jobs name; encoders must compute on ``device``.
        device: where everything happens.
    """

    def __init__(
        self, scene: Scene, view: Viewpoint, networks: Sequence[Networks], device: torch.device
    ) -> None:
        start_ray_tracer()
        _refuse_unfit(device)
        self.scene, self._view = scene, view
        self._device = wp.device_from_torch(str(device))
        self._networks = [Networks(n.encoder, copy.deepcopy(n.rnn).to(device)) for n in networks]
        self._worlds: DeviceWorlds | None = None

    def run(self, jobs: Sequence[Job]) -> list[Trace]:
        """What happened in each job, in their order.

        Raises:
            BelvedereError: a controller or its world model gives actions that are no numbers.
        """
        worlds = self._worlds_for(sum(len(job.episodes) for job in jobs))
        with _one_stream(self._device), torch.inference_mode():
            worlds.reset(Episodes.joined([job.episodes for job in jobs]))
            history, views = _History(worlds), _Views(worlds)
            players = self._players(jobs)
            for frame in range(self.scene.frames):
                for player in players:
                    views.action[player.part] = player.act(views.rgb[player.part])
                worlds.step()
                history.note(frame + 1, views)
            trace = history.trace()
        worlds.check()
        return [trace.part(player.part) for player in players]

    def _worlds_for(self, count: int) -> DeviceWorlds:
        if self._worlds is None or self._worlds.count != count:
            self._worlds = None  # frees the memory before more is asked for
            self._worlds = DeviceWorlds(self.scene, self._view, count, self._device)
        return self._worlds

    def _players(self, jobs: Sequence[Job]) -> list[_Player]:
        ends = np.cumsum([len(job.episodes) for job in jobs]).tolist()
        place = wp.device_to_torch(self._device)
        players = []
        for job, end in zip(jobs, ends, strict=True):
            networks, count = self._networks[job.member], len(job.episodes)
            state = networks.rnn.initial_state(count)
            players.append(_Player(slice(end - count, end), networks, job.controllers.to(place), state))
        return players


@dataclass
class _Player:
    """One job's slice of the worlds, and what plays in them."""

    part: slice
    networks: Networks
    controllers: Controllers
    state: State

    def act(self, pictures: Tensor) -> Tensor:
        """Actions (n, actions) on pictures (n, 64, 64, 3); takes them and z into h."""
        latents = self.networks.encoder.latents(pictures)
        action = self.controllers(latents, self.state.h)
        self.state = self.networks.rnn.step(latents, action, self.state)
        return action


class _Views:
    """The worlds' arrays as torch sees them: the same memory."""

    def __init__(self, worlds: DeviceWorlds) -> None:
        self.rgb, self.action = wp.to_torch(worlds.rgb), wp.to_torch(worlds.action)
        self.qpos, self.tip_m = wp.to_torch(worlds.qpos), wp.to_torch(worlds.tip)
        self.reward, self.error_m = wp.to_torch(worlds.reward), wp.to_torch(worlds.error)


class _History:
    """What happens in an episode, gathered on the device, frame by frame."""

    def __init__(self, worlds: DeviceWorlds) -> None:
        views, frames = _Views(worlds), worlds.scene.frames
        states = (views.qpos, views.tip_m, views.error_m)
        self._qpos, self._tip_m, self._error_m = (_rows(each, frames + 1) for each in states)
        self._action, self._reward = (_rows(each, frames) for each in (views.action, views.reward))
        self._take(0, views)

    def note(self, time: int, views: _Views) -> None:
        """Takes down the worlds after ``time`` frames, and how they came there."""
        self._take(time, views)
        self._action[time - 1], self._reward[time - 1] = views.action, views.reward

    def _take(self, time: int, views: _Views) -> None:
        self._qpos[time], self._tip_m[time], self._error_m[time] = views.qpos, views.tip_m, views.error_m

    def trace(self) -> Trace:
        """The whole episode, on the host."""
        qpos, tip_m, action, reward, error_m = (
            rows.transpose(0, 1).contiguous().cpu().numpy()
            for rows in (self._qpos, self._tip_m, self._action, self._reward, self._error_m)
        )
        tip_m, reward, error_m = (rows.astype(np.float64) for rows in (tip_m, reward, error_m))
        return Trace(qpos, tip_m, action, reward, error_m)


def _refuse_unfit(device: torch.device) -> None:
    """Warp needs more of a CUDA device than torch does."""
    if device.type != "cuda":
        return
    lacks = "is not found" if not wp.is_cuda_available() else ""
    if not lacks and not wp.is_mempool_supported(str(device)):
        lacks = "has no memory pools"
    if lacks:
        raise BelvedereError(
            f"torch can use {device}, but for Warp it {lacks}, so worlds cannot be simulated there; update "
            "NVIDIA's driver, or set BELVEDERE_DEVICE=cpu."
        )


def _rows(like: Tensor, times: int) -> Tensor:
    return like.new_empty((times, *like.shape))


@contextmanager
def _one_stream(device: wp.Device) -> Iterator[None]:
    """Within it torch works on Warp's stream of the device, where it is CUDA."""
    if not device.is_cuda:
        yield
        return
    stream = wp.stream_to_torch(device)
    stream.wait_stream(torch.cuda.current_stream(stream.device))  # on which networks were brought here
    with torch.cuda.stream(stream):
        yield
