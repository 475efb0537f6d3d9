"""`./run python -m benchmarks.sizes SCENE THETA PHI --repeats N [-S PATH=VALUE …]`: what sizes buy.

One viewpoint is trained and evaluated by the stages themselves, one after the other in this process, in a
temporary folder, on one core. The row says what the world model sees, how well its controllers do, how far
repeats scatter, and the processor seconds of one repeat by part. ``-S`` changes params.yaml as DVC's does:
``-S budgets.quick.vae.epochs=6 -S vae.beta=0.1``.

Sizes are chosen on views that are no candidates; the README has the table.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from benchmarks.rows import Row, side_tables
from benchmarks.training import ROOT, command, give_repeats
from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import CORES_VARIABLE
from pipeline.storage.artefacts import read_json
from pipeline.storage.scratch import ENVIRONMENT_VARIABLE
from pipeline.storage.stage import parser

KEY = "sizes"  # the branch's name
PARTS = ("rollouts", "frames", "vae", "latents", "mdnrnn", "controller", "evaluation")
PROBES = ("mlp_tip", "mlp_target", "mlp_tip_to_target", "linear_tip_to_target")
TABLE = "one training, CPU seconds of one core"


def measured(view: dict[str, Any], repeats: int, changes: Sequence[str]) -> Row:
    """The row of a training of ``view`` (scene, theta, phi), ``repeats`` times, with params.yaml changed."""
    with tempfile.TemporaryDirectory() as folder, _working_in(Path(folder)):
        tree = changed(_read("params.yaml"), changes)
        give_repeats(Path(), tree, repeats)
        seconds = {part: _cpu_seconds(part, view) / repeats for part in PARTS}
        _cpu_seconds("anchors", view)
        return row(view, changes, seconds)


def changed(tree: dict[str, Any], changes: Sequence[str]) -> dict[str, Any]:
    """``tree`` with each ``a.b.c=VALUE`` (YAML) put in its place.

    Raises:
        BelvedereError: a change is no such words, or its place is not in the tree.
    """
    for change in changes:
        path, sign, text = change.partition("=")
        *way, last = path.split(".")
        node: Any = tree
        for name in way:
            node = node.get(name) if isinstance(node, dict) else None
        if not sign or not isinstance(node, dict) or last not in node:
            raise BelvedereError(f"-S {change!r}: params.yaml has no value there; write -S vae.beta=0.1")
        node[last] = yaml.safe_load(text)
    return tree


def row(view: dict[str, Any], changes: Sequence[str], seconds: dict[str, float]) -> Row:
    """The row of what the stages wrote in the working folder."""
    vae = read_json(Path("reports/branches", view["scene"], KEY, "vae.json"), "vae")
    evaluation = read_json(Path("reports/branches", view["scene"], KEY, "evaluation.json"), "evaluation")
    anchors = read_json(Path("reports/anchors", f"{view['scene']}.json"), "anchors")
    scores = scored([r["return"] for r in evaluation["repeats"]], anchors)
    return {
        "table": TABLE,
        "view": f"{view['scene']} ({view['theta']:g}, {view['phi']:g})",
        "changes": " ".join(change.removeprefix("budgets.") for change in changes) or "none",
        "repeats": len(scores),
        **{f"{name} cm": 100 * vae[f"probe_{name}_m_mean"] for name in PROBES},
        "guess cm": 100 * vae["guess_tip_to_target_m_mean"],
        "kl nats": vae["kl_nats_mean"],
        "return": evaluation["return_mean"],
        "score": float(scores.mean()),
        "sd": float(scores.std(ddof=1)) if len(scores) > 1 else None,
        **{part: seconds[part] for part in PARTS},
        "all": sum(seconds[part] for part in PARTS if part != "rollouts"),
    }


def scored(returns: Sequence[float], anchors: dict[str, Any]) -> np.ndarray:
    """Returns as scores: 0 is the target-blind anchor's mean, 1 the expert's."""
    blind, expert = anchors["blind_mean"], anchors["expert_mean"]
    return (np.asarray(returns) - blind) / (expert - blind)


def _cpu_seconds(stage: str, view: dict[str, Any]) -> float:
    """Runs a stage in this process; its processor seconds, without imports."""
    _, name, *flags = command(stage, KEY, view)
    main = import_module(name).main
    begin = time.process_time()
    with contextlib.redirect_stderr(io.StringIO()):  # the progress bar
        main(**vars(parser(main).parse_args(flags)))
    return time.process_time() - begin


@contextlib.contextmanager
def _working_in(folder: Path) -> Iterator[None]:
    """Within it this process works in ``folder``, on one core, and finds nothing trained before."""
    before, environment = Path.cwd(), dict(os.environ)
    os.environ |= {CORES_VARIABLE: "1", ENVIRONMENT_VARIABLE: str(folder / ".scratch")}
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
        os.environ.clear()
        os.environ.update(environment)


def _read(name: str) -> Any:
    return yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))


def main(argv: Sequence[str] | None = None) -> None:
    """Prints the row as a table, or with ``--json`` as one object."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.sizes", description=__doc__)
    print_row(options, lambda view, given: measured(view, given.repeats, given.changes), argv)


def print_row(
    options: argparse.ArgumentParser,
    measure: Callable[[dict[str, Any], argparse.Namespace], Row],
    argv: Sequence[str] | None,
) -> None:
    """Reads a study's options (added to ``options``), measures it, prints the row or why there is none."""
    options.add_argument("scene")
    options.add_argument("theta", type=float, help="degrees")
    options.add_argument("phi", type=float, help="degrees")
    options.add_argument("--repeats", type=int, required=True, help="independent trainings, two at least")
    options.add_argument("-S", dest="changes", action="append", default=[], metavar="PATH=VALUE")
    options.add_argument("--json", action="store_true", help="one JSON object")
    given = options.parse_args(argv)
    try:
        found = measure({"scene": given.scene, "theta": given.theta, "phi": given.phi}, given)
    except BelvedereError as error:
        print(f"error: {error}", file=sys.stderr)
        raise SystemExit(1) from None
    print(json.dumps(found, ensure_ascii=False) if given.json else "\n".join(side_tables([found])))


if __name__ == "__main__":
    main()
