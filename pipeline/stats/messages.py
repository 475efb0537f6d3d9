"""The answer in a sentence or two, and a race's progress in a line. Views go by their names in the scene."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pipeline.stats.answer import SURE_FROM, VIEW, Answer
from pipeline.stats.ranks import AS_GOOD, LEADER, NOT_BEST, UNSEEING, Ranked


def sentence(found: Answer) -> str:
    """Where the camera should stand, how sure that is, and what is left open."""
    match found.kind:
        case "cannot see":
            parts = [f"No answer: this judge cannot see the task from {_joined(found, found.rows)}."]
        case "not above blind":
            left = found.of(LEADER, AS_GOOD)
            whose = (
                f"no score of {_joined(found, left)} is"
                if len(left) > 1
                else f"{_joined(found, left)} is not"
            )
            parts = [f"No answer: {whose} surely above target-blind.", _unseeing(found)]
        case "alone":
            parts = [_alone(found), _unsure(found), _unseeing(found)]
        case "either":
            parts = [_either(found), _others(found), _unsure(found), _unseeing(found)]
        case _:
            parts = [_nearest(found), _others(found), _spent(found), _unsure(found), _unseeing(found)]
    return " ".join(part for part in parts if part)


def progress(found: Answer) -> str:
    """A line for a race on its way, or at its end."""
    if found.kind == "cannot see":
        return f"{found.scene}: this judge cannot see the task from {_joined(found, found.rows)}."
    leader, rivals = found.of(LEADER)[0], found.of(AS_GOOD)
    parts = [f"{_name(found, leader)} leads"]
    if rivals:
        parts.append(f"in the race {', '.join(_name(found, row) for row in (leader, *rivals))}")
    if out := found.of(NOT_BEST):
        parts.append(f"out: {', '.join(f'{_name(found, row)} (after {row.out_after})' for row in out)}")
    if unseeing := found.of(UNSEEING):
        parts.append(f"not seen: {', '.join(_name(found, row) for row in unseeing)}")
    so_far = f"Best or within {_up(found.within)} so far." if rivals else "No other view is left."
    where = f"{found.scene}, repeat {found.repeats} of at most {found.most}"
    return f"{where}: {'; '.join(parts)}. {so_far}"


def _alone(found: Answer) -> str:
    (leader,) = found.of(LEADER)
    raced = found.of(LEADER, NOT_BEST)
    if len(raced) == 1:
        whole = found.noun == VIEW and not found.of(UNSEEING)  # only finalists are in a search's
        where = f"of {found.scene}" if whole else "from which this judge sees the task"
        noun = VIEW if found.noun == VIEW else "candidate"
        return f"Put the camera at {_place(leader)}: {_name(found, leader)} is the only {noun} {where}."
    best = f"{_name(found, leader)} is the best of the {len(raced)} {found.noun}s{_level(found)}."
    lead = f"It leads by {found.lead:.2f}, at most {_up(found.lead_high)}."
    return f"Put the camera at {_place(leader)}: {best} {lead}"


def _either(found: Answer) -> str:
    first, second = found.of(LEADER, AS_GOOD)
    both = f"{_name(found, first)} and {_name(found, second)} differ by less than {found.tolerance:g}"
    return f"Put the camera at {_place(first)} or at {_place(second)}, choose either: {both}{_level(found)}."


def _nearest(found: Answer) -> str:
    (leader,) = found.of(LEADER)
    best = f"is the best {found.noun} or within {_up(found.within)} of the best{_level(found)}"
    start = "So far, put the camera at" if found.kind == "open" else "Put the camera at"
    return f"{start} {_place(leader)}: {_name(found, leader)} {best}."


def _others(found: Answer) -> str:
    as_good = found.of(AS_GOOD) if found.kind != "either" else []
    parts = [f"{_joined(found, as_good)} may be as good"] if as_good else []
    if out := found.of(NOT_BEST):
        parts.append(f"{_joined(found, out)} {'are' if len(out) > 1 else 'is'} not the best")
    return f"{'; '.join(parts)}." if parts else ""


def _spent(found: Answer) -> str:
    if found.forecast is None:
        return ""
    start = f"{found.repeats} repeats are spent; about" if found.kind == "ended" else "About"
    noun = "training" if found.forecast == 1 else "trainings"
    return f"{start} {found.forecast} more {noun} would bring it to {found.tolerance:g}."


def _level(found: Answer) -> str:
    return f" ({100 * found.confidence:g} % sure)" if found.sure else ""


def _unsure(found: Answer) -> str:
    if found.sure:
        return ""
    failed = [row for row in found.of(LEADER, AS_GOOD, NOT_BEST) if row.failed]
    whose = f"a training of {_joined(found, failed)}"
    why = f"{whose} came out no better than target-blind"
    return f"How sure is not said before {SURE_FROM} repeats, since {why}."


def _unseeing(found: Answer) -> str:
    unseeing = found.of(UNSEEING)
    return f"From {_joined(found, unseeing)} this judge cannot see the task." if unseeing else ""


def _up(score: float | None) -> str:
    """A bound, rounded away from zero, so that it still holds; never 0.00."""
    return f"{max(1, math.ceil(100 * (score or 0.0) - 1e-9)) / 100:.2f}"


def _place(row: Ranked) -> str:
    return f"({row.theta_deg:g}°, {row.phi_deg:g}°)"


def _name(found: Answer, row: Ranked) -> str:
    return row.key.removeprefix(f"{found.scene}-")


def _joined(found: Answer, rows: Sequence[Ranked]) -> str:
    names = [_name(found, row) for row in rows]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
