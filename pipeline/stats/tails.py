"""The tail that each look of a race may spend, so that the whole race errs as seldom as is promised."""

from __future__ import annotations

from pipeline.contract.errors import BelvedereError, unknown

# Of each level: (most repeats of a race, one-sided tail of a look). Simulated: looks from the third repeat
# on together err in at most 1 - level of races, with one from the second on in up to 5.5 %; fewer err less.
TAILS = {0.95: ((20, 0.008), (40, 0.006))}


def tail(confidence: float, most: int) -> float:
    """The tail probability of each look of a race of at most ``most`` repeats.

    Raises:
        BelvedereError: nothing is known for this level, or for so many repeats.
    """
    if confidence not in TAILS:
        raise unknown("params.yaml: ranking.confidence", confidence, TAILS)
    for repeats, probability in TAILS[confidence]:
        if most <= repeats:
            return probability
    raise BelvedereError(
        f"a race of {most} repeats is too long: its error is known for up to {TAILS[confidence][-1][0]} "
        "only; set race.most of the budget in params.yaml to that or less."
    )
