"""The one error that a user is meant to read."""

from __future__ import annotations


class BelvedereError(Exception):
    """Bad input, told in one sentence: the value, where it came from, what would be valid.

    The stage entry (:func:`pipeline.storage.stage.entry`) prints it without a traceback and
    exits with status 1; every other exception is a defect of the program and keeps its traceback.
    """


def unknown(kind: str, name: object, available: object) -> BelvedereError:
    """The error for a name that is not in a closed list.

    Args:
        kind: what was looked up, such as ``"scene"``.
        name: the value given.
        available: the iterable of valid names.
    """
    valid = ", ".join(sorted(str(a) for a in available)) or "none"  # type: ignore[attr-defined]
    return BelvedereError(f"{kind} {str(name)!r} is unknown; available: {valid}.")
