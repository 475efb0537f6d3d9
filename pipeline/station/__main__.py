"""`./run station`: people at a gamepad drive the simulated arm and are recorded (docs/station.md)."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.station.study import Study
from pipeline.study.params import PeopleParams

PORT = 8425
DEMONSTRATION = Path("data/demonstration")
_COMMANDS = """commands:
  ./run station                 a session of a new participant
  ./run station resume CODE     goes on with a session: its plan minus the trials that ended
  ./run station withdraw CODE   removes a participant everywhere
  ./run station demonstrate     a session of the scripted operator, without a browser; synthetic data
"""


class _Parser(argparse.ArgumentParser):
    """A parser that tells what is wrong in one sentence."""

    def error(self, message: str) -> NoReturn:
        raise BelvedereError(f"{message}; `./run station --help` lists commands and flags.")


def parser() -> argparse.ArgumentParser:
    """The command line."""
    top = _Parser(
        prog="./run station",
        description=__doc__,
        epilog=_COMMANDS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("command", nargs="?", choices=["resume", "withdraw", "demonstrate"], help="see below")
    top.add_argument("code", nargs="?", metavar="CODE", help="a participant's, for resume and withdraw")
    top.add_argument("--study", type=Path, help="folder of sessions, instead of people.study of params.yaml")
    top.add_argument("--port", type=int, default=PORT, help=f"on 127.0.0.1; 0 takes a free one; {PORT}")
    top.add_argument(
        "--scene", action="append", help="of the session, instead of station.tasks; may be repeated"
    )
    top.add_argument(
        "--views", nargs="+", metavar="VIEW", help="to compare, instead of each scene's first ones"
    )
    top.add_argument("--seed", type=int, help="of the plan, instead of that of params.yaml")
    top.add_argument(
        "--operator", choices=["person", "scripted"], default="person", help="who drives the arm"
    )
    top.add_argument("--participants", type=int, default=1, metavar="N", help="of demonstrate")
    return top


def main(argv: Sequence[str] | None = None) -> None:
    """Runs a command.

    Raises:
        BelvedereError: something that was asked or found is not valid.
    """
    given = parser().parse_args(argv)
    if (given.command in ("resume", "withdraw")) != (given.code is not None):
        raise BelvedereError("resume and withdraw take a participant's CODE, and no other command does.")
    if not 0 <= given.port < 2**16:
        raise BelvedereError(f"--port {given.port} is not valid; it lies between 0 and 65535.")
    if given.seed is not None and not 0 <= given.seed < 2**63:
        raise BelvedereError(f"--seed {given.seed} is not valid; it is a whole number from 0 up, below 2⁶³.")
    if given.command == "withdraw":
        withdraw(_study(given), given.code)
    elif given.command == "demonstrate":
        from pipeline.station.demonstrate import demonstrate

        demonstrate(given.study or DEMONSTRATION, given.participants, given.seed, given.scene, given.views)
    else:
        _serve(given)


def _study(given: argparse.Namespace) -> Path:
    if given.study is not None:
        return Path(given.study)
    if given.operator == "scripted":
        return DEMONSTRATION
    return Path(params.section(PeopleParams, "people").study)


def _serve(given: argparse.Namespace) -> None:
    from pipeline.station.serve import Asked, serve

    serve(
        Asked(
            study=_study(given),
            port=given.port,
            operator=given.operator,
            seed=given.seed,
            scenes=tuple(given.scene) if given.scene else None,
            views=given.views,
            resume=given.code,
        )
    )


def withdraw(folder: Path, code: str) -> None:
    """Removes a participant's data and says what else may hold some."""
    study = Study(folder)
    with study.alone():
        removed = study.withdraw(code)
    print(f"participant {code} is removed from:")
    for path in removed:
        print(f"  {path}")
    print(
        "If the folder was tracked with dvc: commit the removed .dvc file, run `./run dvc repro report` and\n"
        "`./run dvc gc --workspace` (--cloud where it was pushed); docs/station.md says what each clears."
    )


if __name__ == "__main__":
    sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    try:
        main()
    except BelvedereError as error:
        print(f"error: {error}", file=sys.stderr)
        raise SystemExit(1) from None
    except KeyboardInterrupt:
        raise SystemExit(130) from None
