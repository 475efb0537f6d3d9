"""Do views differ by tilt and pan, and does that depend on the judge? (paper section III)

All of it in normalised score, in which 0.1 is a tenth of the way from blind to the expert. The
questions are fixed here, before any result is seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from pipeline.stats.blocks import mean_half_width, two_way
from pipeline.stats.branches import Results
from pipeline.stats.claims import Claim, Judgement, Step, held
from pipeline.stats.dqn import DqnResults
from pipeline.stats.factorial import Difference, Factorial, factorial, find_grid
from pipeline.stats.judges import effects_by_judge, judge_by_view
from pipeline.stats.params import RankingParams

WORLD_MODEL, DQN = "world model", "dqn"


def comparison(
    results: Results, dqn: DqnResults | None, claims: Sequence[Claim], params: RankingParams
) -> dict[str, Any]:
    """The parts ``factorial``, ``dqn``, ``judges`` and ``claims`` of a scene's ranking.

    Parts that cannot be had (no grid of views, one repeat, no networks) are ``None``.
    """
    confidence = params.confidence
    ours = _factorial(results, list(results.branches), results.scores, params)
    judged = {WORLD_MODEL: Judgement(_steps(ours), _above_blind(results.scores, confidence))} if ours else {}
    content: dict[str, Any] = {"factorial": asdict(ours) if ours else None, "dqn": None, "judges": None}
    if dqn is not None:
        content |= _with_dqn(results, dqn, ours, params, judged)
    return {**content, "claims": [found.model_dump() for found in held(claims, judged)]}


def _with_dqn(
    results: Results,
    dqn: DqnResults,
    ours: Factorial | None,
    params: RankingParams,
    judged: dict[str, Judgement],
) -> dict[str, Any]:
    """The networks' part and the judges' part; adds the networks' judgement to ``judged``."""
    scores = dqn.scores(results.anchors["blind"], results.anchors["expert"])
    restricted = dqn.scores(results.anchors["blind"], dqn.restricted_expert)
    theirs = _factorial(results, dqn.keys, scores, params)
    rows = [_row(*numbers) for numbers in zip(dqn.returns, scores, restricted, strict=True)]
    part = {
        "repeats": scores.shape[1],
        "viewpoints": dict(zip(dqn.keys, rows, strict=True)),
        "score_half_width": mean_half_width(two_way(scores), params.confidence),
        "restricted_expert_return": float(dqn.restricted_expert.mean()),
        "factorial": asdict(theirs) if theirs else None,
    }
    judges = None
    if ours and theirs and _levels(ours) == _levels(theirs):
        judged[DQN] = Judgement(_steps(theirs), _above_blind(scores, params.confidence))
        common = [list(results.branches).index(key) for key in dqn.keys]
        test = judge_by_view(results.scores[common], scores)
        effects = effects_by_judge(ours, theirs, params.confidence)
        steps = [_step(effect, _word(effect.low, effect.high)) for effect in effects]
        able = all(judge.above_blind for judge in judged.values())
        judged[f"{WORLD_MODEL} over {DQN}"] = Judgement(steps, able)
        judges = {"test": asdict(test) if test else None, "effects": [asdict(effect) for effect in effects]}
    return {"dqn": part, "judges": judges}


def _factorial(
    results: Results, keys: Sequence[str], scores: np.ndarray, params: RankingParams
) -> Factorial | None:
    branches = [results.branches[key] for key in keys]
    grid = find_grid([b.theta for b in branches], [b.phi for b in branches])
    return factorial(scores, grid, params.confidence, params.equivalence_margin) if grid else None


def _row(returns: np.ndarray, scores: np.ndarray, restricted: np.ndarray) -> dict[str, float]:
    means = {"return_mean": returns, "score_mean": scores, "score_of_restricted_mean": restricted}
    return {name: float(values.mean()) for name, values in means.items()}


def _above_blind(scores: np.ndarray, confidence: float) -> bool:
    """Whether the interval of some view's mean score lies above 0."""
    fit = two_way(scores)
    half = mean_half_width(fit, confidence)
    return half is not None and bool((fit.means - half > 0).any())


def _levels(found: Factorial) -> list[tuple[str, float, float]]:
    return [(effect.factor, effect.first_deg, effect.second_deg) for effect in found.effects]


def _steps(found: Factorial) -> list[Step]:
    return [_step(effect, effect.word) for effect in found.effects]


def _step(found: Difference, word: str) -> Step:
    return Step(**{field.name: getattr(found, field.name) for field in fields(Difference)}, word=word)


def _word(low: float, high: float) -> str:
    """Of an interaction: no margin was fixed for one, so it is never called none."""
    return "differs" if low > 0 or high < 0 else "not separated"
