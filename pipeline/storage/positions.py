"""Where a store's targets are, frame by frame, and how far what shall come there is from them."""

from __future__ import annotations

import numpy as np

from pipeline.storage.zarrs import Store


def target_by_frame(store: Store, repeat: int) -> np.ndarray:
    """The targets of rollouts or frames: (episode, frame, 3), m; they rest where no path is stored."""
    if store.has("target_path"):
        return store.repeat("target_path", repeat)
    target_m, (episodes, frames) = store.repeat("target", repeat), store.shape("reward")
    return np.broadcast_to(target_m[:, None], (episodes, frames, 3))


def error_by_frame(store: Store, repeat: int) -> np.ndarray:
    """The task's error, (episode, frame, 3), m: from the target to what shall come there.

    That is the tip where no error is stored.
    """
    if store.has("error"):
        return store.repeat("error", repeat)
    return np.asarray(store.repeat("tip", repeat) - target_by_frame(store, repeat))
