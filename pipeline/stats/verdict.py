"""What a scene's table says, in a word and in a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.stats.ranks import BEST, NOT_ABOVE_BLIND, NOT_SEPARATED, Ranked


@dataclass(frozen=True)
class Verdict:
    """A scene's verdict.

    Attributes:
        kind: ``best``, ``not separated`` or ``not above blind``.
        keys: the branches it speaks of, best first.
        sentence: the same for people.
        more_repeats: about how many would separate the first two, if so small a gap as theirs is real.
    """

    kind: str
    keys: list[str]
    sentence: str
    more_repeats: int | None = None


def scene_verdict(scene: str, table: Sequence[Ranked], confidence: float, needed: int | None) -> Verdict:
    """The verdict of a scene's table (best first): one view only if it is separated from all others.

    ``needed`` are the repeats at which a gap as large as that between the first two would be told.
    """
    first = table[0]
    if first.repeats > 1 and not any(row.above_blind for row in table):
        keys = [row.key for row in table]
        return Verdict(
            NOT_ABOVE_BLIND,
            keys,
            f"No view is above blind: {', '.join(keys)}; no score's {_level(confidence)} lies above 0.",
        )
    if first.verdict == BEST:
        return Verdict(BEST, [first.key], _best(first, table[1], confidence))
    # A best view that is not above blind cannot be chosen, even where it is separated in return.
    keys = [row.key for row in table if row.tied or (row.above_blind and not first.above_blind)]
    more = needed - first.repeats if needed and needed > first.repeats else None
    return Verdict(NOT_SEPARATED, keys, _not_separated(scene, table, keys, more), more)


def _level(confidence: float) -> str:
    return f"{100 * confidence:g} % interval"


def _best(best: Ranked, second: Ranked, confidence: float) -> str:
    difference, low, high = second.difference_to_best, second.difference_low, second.difference_high
    if difference is None or low is None or high is None:
        raise ValueError(f"{second.key} has no difference to the best view")
    return (
        f"Put the camera at (θ, φ) = ({best.theta_deg:g}°, {best.phi_deg:g}°): {best.key} returns "
        f"{-difference:.3g} m more than the next best view, {second.key} "
        f"({_level(confidence)} {-high:.3g} to {-low:.3g})."
    )


def _not_separated(scene: str, table: Sequence[Ranked], keys: Sequence[str], more: int | None) -> str:
    no_error = "one repeat tells no error" if table[0].repeats == 1 else ""
    if len(table) == 1:
        why = no_error or "there is nothing to compare it with"
        return f"Not separated: {keys[0]} is the only view of {scene}, and {why}."
    also = no_error or (f"about {more} more repeats would tell the first two apart" if more else "")
    return f"Not separated: {'; '.join(part for part in (', '.join(keys), also) if part)}."
