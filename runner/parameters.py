"""Parameters are checked before DVC is asked: it deletes a stage's outputs before the stage says a word."""

from __future__ import annotations

import subprocess
import sys

from pipeline.contract.errors import BelvedereError

_CHECK = (sys.executable, "-m", "pipeline.checks.parameters")
_TOLD = "error: "


def check_parameters() -> None:
    """Checks params.yaml in the working directory, in a process of its own: here no stage is imported.

    Raises:
        BelvedereError: a value is not valid.
    """
    done = subprocess.run(_CHECK, stderr=subprocess.PIPE, text=True)
    said = done.stderr.strip()
    if done.returncode and said.startswith(_TOLD):
        raise BelvedereError(said.removeprefix(_TOLD))
    sys.stderr.write(done.stderr)
    if done.returncode:
        raise BelvedereError(f"params.yaml could not be checked; see above (exit status {done.returncode}).")
