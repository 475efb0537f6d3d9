"""The closed loop as one would write it without Belvedere: one world, one picture, one step at a time.

It follows the rollout of github.com/ctallec/world-models: networks as published, in float32, on one
picture; the simulation through dm_control; MuJoCo's own renderer. What that project computes besides
and throws away (the decoder, the mixture of the MDN-RNN) is left out, in the peer's favour.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import torch
from torch import nn

from benchmarks.loops import Setting
from benchmarks.render import stripped_renderer
from benchmarks.vae import published
from pipeline.control.policy import FEATURES
from pipeline.rendering.renderer import model_seen_from
from pipeline.rendering.visibility import PICTURE_SIZE
from pipeline.sim.draws import Episodes
from pipeline.sim.environment import environment
from pipeline.sim.scene import CAMERA
from pipeline.worldmodel.mdnrnn import UNITS, MdnRnn
from pipeline.worldmodel.vae import LATENTS

Draw = Callable[[mujoco.MjData], np.ndarray]  # bytes (64, 64, 3)
STRIPPED, AS_IT_COMES = "stripped", "as it comes"


def renderer(model: mujoco.MjModel, kind: str) -> Draw:
    """MuJoCo's renderer, as it comes (shadows, four samples a pixel) or stripped of both.

    Belvedere's lights are told to cast no shadow; for the former they cast them, as MuJoCo's lights
    do unless told otherwise.
    """
    if kind == STRIPPED:
        made = stripped_renderer(model)
    else:
        model.light_castshadow[:] = True
        made = mujoco.Renderer(model, PICTURE_SIZE, PICTURE_SIZE)

    def draw(data: mujoco.MjData) -> np.ndarray:
        made.update_scene(data, CAMERA)
        return np.asarray(made.render())

    return draw


def lstm_cell(rnn: MdnRnn) -> nn.LSTMCell:
    """torch's cell with the weights of the MDN-RNN."""
    cell = nn.LSTMCell(LATENTS + rnn.actions, UNITS)
    cell.load_state_dict({name.removesuffix("_l0"): value for name, value in rnn.lstm.state_dict().items()})
    return cell


class PlainLoop:
    """Runs one controller in one episode at a time.

    Args:
        chosen: scene, view and world model.
        drawn_by: gives, for the model with its camera at the view, what draws a state.
    """

    def __init__(self, chosen: Setting, drawn_by: Callable[[mujoco.MjModel], Draw]) -> None:
        scene, model = chosen.scene, model_seen_from(chosen.scene, chosen.view)
        self._environment = environment(replace(scene, model=model), np.random.default_rng(1))
        self._draw = drawn_by(model)
        self._vae, self._cell = published(chosen.vae), lstm_cell(chosen.rnn)
        self._controller = nn.Linear(FEATURES, scene.action_size)

    @torch.inference_mode()
    def run(self, flat: np.ndarray, episode: Episodes) -> float:
        """The return of the controller ``flat`` (actions × 289,) in an episode (of length 1)."""
        rows = torch.from_numpy(flat.astype(np.float32)).view(-1, FEATURES + 1)
        self._controller.weight.copy_(rows[:, :-1])
        self._controller.bias.copy_(rows[:, -1])
        self._environment.task.start_with(episode)
        step, total = self._environment.reset(), 0.0
        h = c = torch.zeros(1, UNITS)
        while not step.last():
            picture = torch.from_numpy(self._draw(self._environment.physics.data.ptr))
            z, _ = self._vae.encode(picture.permute(2, 0, 1)[None].float() / 255)
            action = torch.tanh(self._controller(torch.cat([z, h], dim=1)))
            step = self._environment.step(action[0].numpy())
            h, c = self._cell(torch.cat([z, action], dim=1), (h, c))
            total += step.reward
        return total
