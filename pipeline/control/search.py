"""One repeat's search for a controller: where it starts, and by which episodes candidates are judged."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.contract import seeds
from pipeline.contract.seeds import Stream
from pipeline.control.evolution import Search, evolve, start
from pipeline.control.first import Experience, from_rewards
from pipeline.control.loop import Loop
from pipeline.control.params import ControllerParams, SearchSizes
from pipeline.control.policy import hidden_weights, parameters
from pipeline.sim.draws import draw_episodes


def search_controller(
    loop: Loop,
    experience: Experience,
    method: ControllerParams,
    sizes: SearchSizes,
    seed: int,
    repeat: int,
    running: Path,
) -> Search:
    """Evolves a controller in the closed loop.

    Args:
        loop: the closed loop, in which candidates are judged.
        experience: the random episodes, from which the search starts.
        method: where it starts and how widely.
        sizes: of the search.
        seed: the root of every draw.
        repeat: its draws are the same in every view.
        running: folder of the checkpoint, from which a killed search goes on.
    """
    axes = loop.scene.action_size

    def judge(candidates: np.ndarray, draws: np.random.Generator) -> np.ndarray:
        return loop.judge(candidates, draw_episodes(loop.scene, sizes.episodes, draws))

    candidates = seeds.generator(seed, repeat, Stream.EVOLUTION)
    draws = seeds.generator(seed, repeat, Stream.TRAINING_EPISODES)
    first = np.zeros(parameters(axes))
    if method.first == "rewards":
        first = from_rewards(loop.rnn, experience, method.ridge)
    shares = np.where(hidden_weights(axes), method.hidden_share, 1.0)
    search = start(first, sizes.population, method, candidates, draws, shares)
    return evolve(search, judge, sizes.generations, running, f"controller, repeat {repeat}")
