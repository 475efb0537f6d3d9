"""Which arrays the stores hold, and what their numbers mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """One named array of a store.

    Attributes:
        dims: axis names; the first is ``episode``.
        dtype: NumPy dtype name.
        unit: physical unit, or what the numbers are.
    """

    dims: tuple[str, ...]
    dtype: str
    unit: str


Schema = Mapping[str, Column]

_EPISODE = ("episode",)
_FRAME = ("episode", "frame")

# Beside these in rollouts and frames of tasks in which tip and a resting target do not tell them.
TASK: Schema = {
    "target_path": Column((*_FRAME, "xyz"), "float32", "m, the target before the action"),
    "error": Column((*_FRAME, "xyz"), "float32", "m, from the target to what shall come there"),
}
ROLLOUTS: Schema = {
    "qpos": Column((*_FRAME, "coordinate"), "float32", "MuJoCo generalised positions (rad, m)"),
    "tip": Column((*_FRAME, "xyz"), "float32", "m, world frame, before the action"),
    "action": Column((*_FRAME, "axis"), "float32", "share of the largest displacement, -1 to 1"),
    "reward": Column(_FRAME, "float32", "m, eq. (1), after the action"),
    "target": Column((*_EPISODE, "xyz"), "float32", "m, world frame"),
}
FRAMES: Schema = {
    "rgb": Column((*_FRAME, "row", "column", "channel"), "uint8", "sRGB, 0 to 255"),
    "tip": ROLLOUTS["tip"],
    "action": ROLLOUTS["action"],
    "reward": ROLLOUTS["reward"],
    "target": ROLLOUTS["target"],
    "target_pixels": Column(_FRAME, "int32", "pixels in which the target is seen"),
    "target_pixels_free": Column(_EPISODE, "int32", "the same, were nothing in front of it"),
}
LATENTS: Schema = {
    "mean": Column((*_FRAME, "latent"), "float32", "posterior mean of z"),
    "log_variance": Column((*_FRAME, "latent"), "float32", "posterior log variance of z"),
    "action": ROLLOUTS["action"],
    "reward": ROLLOUTS["reward"],
}
