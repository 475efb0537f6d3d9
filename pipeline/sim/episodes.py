"""How many episodes of a scene fit into memory: what they leave behind is known before the first is run."""

from __future__ import annotations

from pipeline.contract import memory, params
from pipeline.sim.scene import Scene

_WORLD_BYTES = 8 * 2**10  # of a batch; with 64 to 4096 worlds of Panda or Fetch a process grew by 5 KiB each
_COPIES = 3  # of what is kept of an episode: frame by frame, stacked, and rounded or written


def episode_bytes(scene: Scene) -> int:
    """What a world and all that is kept of its episode take: positions, tip, action, its noise, reward,
    and where the task has some, its target's path and its error."""
    own = 6 if scene.task.own_arrays else 0
    frame = 4 * scene.model.nq + 8 * (3 + 2 * scene.action_size + 1 + own)
    return _WORLD_BYTES + _COPIES * scene.frames * frame


def require_episodes(scene: Scene, count: int, stage: str, repeats: int = 1) -> None:
    """Refuses more episodes at a time than fit into memory.

    Args:
        scene: whose.
        count: of a repeat, ``episodes`` of ``stage`` in the chosen budget.
        stage: the stage's section of the budget.
        repeats: whose episodes are run at a time.

    Raises:
        BelvedereError: they need more memory than there is.
    """
    each = repeats * episode_bytes(scene)
    place = f"{params.PARAMS_FILE}: budgets.{params.budget()}.{stage}.episodes"
    many = f", {repeats} repeats at a time" if repeats > 1 else ""
    memory.require(
        count * each,
        f"{place} = {count}, of {scene.frames} frames (scenes.{scene.name}.frames){many},",
        lambda there: f"at most {there // each} episodes fit",
    )
