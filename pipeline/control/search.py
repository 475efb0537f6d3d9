"""The searches for a controller, one a repeat: where they start, and by which episodes they evaluate."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.contract import params, seeds
from pipeline.contract.machine import cores
from pipeline.contract.seeds import Stream
from pipeline.control.evolution import Generation, Run, Search, evolve, start
from pipeline.control.first import Experience, from_rewards
from pipeline.control.jobs import Job
from pipeline.control.loops import Loops, mean_returns
from pipeline.control.params import ControllerParams, SearchSizes
from pipeline.control.policy import hidden_weights, parameters
from pipeline.sim.draws import draw_episodes
from pipeline.storage.sight import read_sight
from pipeline.worldmodel.mdnrnn import MdnRnn


def search_sizes(scene: str, probes: Path, first: int) -> SearchSizes:
    """The budget's sizes, with one generation where the latent does not tell tip - target.

    ``probes`` are the VAE's metrics, of which the first repeats count.
    """
    sizes = params.budget_section(SearchSizes, "controller", scene)
    sight = read_sight(probes, probes.parent.name, first, params.sight_share())
    return sizes.model_copy(update={"generations": 1}) if sight.misses else sizes


@dataclass(frozen=True, eq=False)
class Repeat:
    """One repeat's search, before it begins.

    Attributes:
        number: its draws are the same in every view.
        experience: the random episodes, from which the search starts.
        rnn: what h comes from.
        running: folder of the checkpoint, from which a killed search goes on.
    """

    number: int
    experience: Experience
    rnn: MdnRnn
    running: Path


def search_controllers(
    loops: Loops, repeats: Sequence[Repeat], method: ControllerParams, sizes: SearchSizes, seed: int
) -> list[Search]:
    """Evolves the repeats' controllers in their closed loops, generation by generation.

    Args:
        loops: in which candidates are evaluated; repeat ``i`` sees through its networks ``i``.
        repeats: those that search; each ends with the same bytes whichever others do.
        method: where they start and how widely.
        sizes: of each search.
        seed: the root of every draw.
    """

    runs = []
    for repeat in repeats:
        search = first_search(repeat, loops.scene.action_size, method, sizes, seed)
        runs.append(Run(search, repeat.running, f"controller, repeat {repeat.number}"))
    with ThreadPoolExecutor(cores()) as pool:  # a GPU would wait for what is drawn one by one

        def evaluated(generations: Sequence[Generation]) -> list[np.ndarray]:
            drawn = pool.map(lambda g: draw_episodes(loops.scene, sizes.episodes, g.draws), generations)
            pairs = zip(generations, drawn, strict=True)
            return mean_returns(
                loops, [Job.of(g.member, g.candidates, e) for g, e in pairs], sizes.population
            )

        return evolve(runs, evaluated, sizes.generations, f"controller, {len(repeats)} repeats")


def first_search(
    repeat: Repeat, actions: int, method: ControllerParams, sizes: SearchSizes, seed: int
) -> Search:
    """Where a repeat's search starts."""
    candidates = seeds.generator(seed, repeat.number, Stream.EVOLUTION)
    draws = seeds.generator(seed, repeat.number, Stream.TRAINING_EPISODES)
    first = np.zeros(parameters(actions))
    if method.first == "rewards":
        first = from_rewards(repeat.rnn, repeat.experience, method.ridge)
    shares = np.where(hidden_weights(actions), method.hidden_share, 1.0)
    return start(first, sizes.population, method, candidates, draws, shares)
