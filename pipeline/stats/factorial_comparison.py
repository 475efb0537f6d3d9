"""Do views differ by tilt and pan, and does that depend on the judge? (paper section III)

All of it in normalised score, in which 0.1 is a tenth of the way from target-blind to the expert, over the
repeats that all views concerned have. The questions are fixed here, before any result is seen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pipeline.contract.viewpoints import Viewpoint
from pipeline.stats.blocks import mean_half_width, own_interval, two_way
from pipeline.stats.branches import Results
from pipeline.stats.claims import Claim, Judgement, held
from pipeline.stats.dqn import DqnResults
from pipeline.stats.factorial import Effect, Factorial, factorial, find_grid
from pipeline.stats.judges import EffectByJudge, effects_by_judge, judge_by_view
from pipeline.stats.params import RankingParams
from pipeline.stats.steps import Step

WORLD_MODEL, DQN = "world model", "dqn"


@dataclass(frozen=True)
class _Found:
    """A judge's effects over the grid that its views form: the branches on it, and its scores there."""

    keys: list[str]
    scores: dict[str, np.ndarray]
    effects: Factorial


def comparison(
    results: Results, dqn: DqnResults | None, claims: Sequence[Claim], params: RankingParams
) -> dict[str, Any]:
    """The parts ``factorial``, ``dqn``, ``judges`` and ``claims`` of a scene's ranking.

    Parts that cannot be had (no grid of views, no networks) are ``None``.
    """
    ours = _on_grid(results.branches, results.scores, params)
    judged = {WORLD_MODEL: _judgement(ours, results, params)} if ours else {}
    content: dict[str, Any] = {
        "factorial": asdict(ours.effects) if ours else None,
        "dqn": None,
        "judges": None,
    }
    if dqn is not None:
        content |= _with_dqn(results, dqn, ours, params, judged)
    return {**content, "claims": [found.model_dump() for found in held(claims, judged)]}


def _with_dqn(
    results: Results,
    dqn: DqnResults,
    ours: _Found | None,
    params: RankingParams,
    judged: dict[str, Judgement],
) -> dict[str, Any]:
    """The networks' part and the judges' part; adds the networks' judgement to ``judged``."""
    scores = (dqn.returns - results.blind_m) / results.unit_m
    restricted = (dqn.returns - results.blind_m) / (float(dqn.restricted_expert.mean()) - results.blind_m)
    by_key = dict(zip(dqn.keys, scores, strict=True))
    theirs = _on_grid({key: results.branches[key] for key in dqn.keys}, by_key, params)
    rows = [_row(*numbers) for numbers in zip(dqn.returns, scores, restricted, strict=True)]
    part = {
        "repeats": scores.shape[1],
        "viewpoints": dict(zip(dqn.keys, rows, strict=True)),
        "score_half_width": mean_half_width(two_way(scores), params.confidence),
        "restricted_expert_return": float(dqn.restricted_expert.mean()),
        "factorial": asdict(theirs.effects) if theirs else None,
    }
    judges = None
    if ours and theirs and _levels(ours) == _levels(theirs):
        judges = _two_judges(results, ours, theirs, params, judged)
    return {"dqn": part, "judges": judges}


def _two_judges(
    results: Results, ours: _Found, theirs: _Found, params: RankingParams, judged: dict[str, Judgement]
) -> dict[str, Any]:
    margin = params.equivalence_margin
    above = _above_blind(theirs, params.confidence)
    judged[DQN] = Judgement([_step(effect) for effect in theirs.effects.effects], margin, above)
    test = judge_by_view(_common(ours.scores, theirs.keys), _common(theirs.scores, theirs.keys))
    effects = effects_by_judge(ours.effects, theirs.effects, params.confidence)
    able = all(judge.above_blind for judge in judged.values())
    unseen = judged[WORLD_MODEL].unseen
    judged[f"{WORLD_MODEL} over {DQN}"] = Judgement([_step(e) for e in effects], margin, able, unseen)
    return {"test": asdict(test) if test else None, "effects": [asdict(effect) for effect in effects]}


def _on_grid(
    branches: Mapping[str, Viewpoint], scores: Mapping[str, np.ndarray], params: RankingParams
) -> _Found | None:
    """The effects over the grid's common repeats; views beside the grid play no part."""
    grid = find_grid([b.theta for b in branches.values()], [b.phi for b in branches.values()])
    if grid is None:
        return None
    keys = list(branches)
    on = [keys[view] for view in grid.views.ravel()]
    own = {key: scores[key] for key in on}
    values = np.full((len(keys), min(len(found) for found in own.values())), np.nan)
    values[grid.views.ravel()] = _common(own, on)
    found = factorial(values, grid, params.confidence, params.equivalence_margin)
    return _Found(on, own, found) if found else None


def _common(scores: Mapping[str, np.ndarray], keys: Sequence[str]) -> np.ndarray:
    """(view, repeat) over the repeats that all of them have."""
    least = min(len(scores[key]) for key in keys)
    return np.array([scores[key][:least] for key in keys])


def _judgement(found: _Found, results: Results, params: RankingParams) -> Judgement:
    """The world model's."""
    dark = [results.branches[key] for key in found.keys if results.sight[key].misses]
    steps = [_step(effect) for effect in found.effects.effects]
    above = _above_blind(found, params.confidence)
    return Judgement(steps, params.equivalence_margin, above, [(view.theta, view.phi) for view in dark])


def _row(returns: np.ndarray, scores: np.ndarray, restricted: np.ndarray) -> dict[str, float]:
    means = {"return_mean": returns, "score_mean": scores, "score_of_restricted_mean": restricted}
    return {name: float(values.mean()) for name, values in means.items()}


def _above_blind(found: _Found, confidence: float) -> bool:
    """Whether the interval of some view's mean score lies above 0."""
    lows = [own_interval(values, confidence)[1] for values in found.scores.values()]
    return any(low is not None and low > 0 for low in lows)


def _levels(found: _Found) -> list[tuple[str, float, float]]:
    return [(effect.factor, effect.first_deg, effect.second_deg) for effect in found.effects.effects]


def _step(found: Effect | EffectByJudge) -> Step:
    """Of an interaction no margin was fixed, so its size is not told."""
    narrow = (found.equivalence_low, found.equivalence_high) if isinstance(found, Effect) else (None, None)
    levels = (found.factor, found.first_deg, found.second_deg)
    return Step(*levels, found.difference, found.low, found.high, *narrow)
