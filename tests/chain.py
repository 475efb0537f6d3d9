"""A small study taken through every stage of dvc.yaml, in this process, in the working directory."""

from __future__ import annotations

import importlib
import re
import shlex
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from pipeline.storage.stage import entry
from tests.support import ROOT

SCENE, CANDIDATE = "panda_2dof", "panda_2dof-a"
STAGES: dict[str, Any] = yaml.safe_load((ROOT / "dvc.yaml").read_text(encoding="utf-8"))["stages"]
SCENES = ("data", "scenes")
IN_ORDER = (
    *(
        "scene",
        "rollouts",
        "anchors",
        "frames",
        "geometry",
        "operator",
        "vae",
        "latents",
        "mdnrnn",
        "controller",
        "evaluation",
    ),
    *("dqn", "ranking", "trials", "people", "report"),
)
_SIZES = {
    "about": "a test",
    "race": {"first": 2, "most": 2},
    "rollouts": {"episodes": 4},
    "vae": {"epochs": 1, "batch": 8, "frame_stride": 1},
    "mdnrnn": {"epochs": 1, "batch": 2},
    "controller": {"population": 4, "episodes": 2, "generations": 2},
    "evaluation": {"episodes": 4},
}


@dataclass(frozen=True)
class Step:
    """A stage as dvc.yaml declares it, with its templates filled in.

    Attributes:
        name: the stage's.
        flags: of its command.
        deps: what it reads, its code left out.
        outs: what it writes.
    """

    name: str
    flags: list[str]
    deps: list[Path]
    outs: list[Path]

    def run(self) -> None:
        """Runs it as its script would; ends by SystemExit where that would not end with status 0."""
        entry(importlib.import_module(f"pipeline.{self.name}").main, self.flags)

    @property
    def files(self) -> list[Path]:
        """All files that it reads. What is said of episodes has their store beside it, which is no dep of its
        own, or one more repeat would make every viewpoint again."""
        stores = [dep.with_suffix("") for dep in self.deps if dep.parts[:2] == ("data", "rollouts")]
        return files_below([*self.deps, *stores])


def files_below(places: list[Path]) -> list[Path]:
    """The files among ``places`` and in those that are folders."""
    return sorted(file for place in places for file in [place, *place.rglob("*")] if file.is_file())


def write_inputs(folder: Path) -> None:
    """What the repository holds of inputs, with small sizes, one scene and one candidate beside the study."""
    tree = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
    tree["scenes"] = {SCENE: tree["scenes"][SCENE] | {"frames": 6}}
    tree["viewpoints"] = {CANDIDATE: tree["viewpoints"][CANDIDATE]}
    tree["operator"] |= {"trials": 2, "limit_s": 4}
    tree["sight_share"] = 0.9999  # so small a judge sees little, and without a race a ranking says little
    tree["budget"], tree["budgets"] = "short", {"short": _SIZES | {"dqn": tree["budgets"]["tiny"]["dqn"]}}
    (folder / "params.yaml").write_text(yaml.safe_dump(tree, sort_keys=False), encoding="utf-8")
    listed = {"study": "${viewpoint}", CANDIDATE: f"${{viewpoints.{CANDIDATE}}}"}
    stages = {"stages": {"evaluation": {"foreach": listed}}}
    (folder / "dvc.yaml").write_text(yaml.safe_dump(stages), encoding="utf-8")
    shutil.copytree(ROOT / "data/reference", folder / "data/reference")
    shutil.copytree(ROOT / "robots", folder / "robots")
    for name in ("searches", "ablations"):
        (folder / "reports" / name).mkdir(parents=True)
    (folder / "data/study").mkdir()
    for name in ("README", "dataset_description.json"):
        shutil.copy(ROOT / "data/study" / name, folder / "data/study" / name)
    for name in ("data/tried.csv", "data/allocation.yaml"):
        shutil.copy(ROOT / name, folder / name)


def steps(name: str) -> list[Step]:
    """The stage ``name`` of the scene, or of each branch; of the study last."""
    form = STAGES[name]
    if "foreach" not in form:
        return [_step(name, form, {"people.study": "data/study"})]
    if form["foreach"] == "${scenes}":
        return [_step(name, form["do"], {"key": SCENE})]
    params = yaml.safe_load(Path("params.yaml").read_text(encoding="utf-8"))
    views = {**params["viewpoints"], "study": params["viewpoint"]}
    return [
        _step(name, form["do"], {"key": key, **{f"item.{k}": v for k, v in view.items()}})
        for key, view in views.items()
        if key in form["foreach"]
    ]


def _step(name: str, form: dict[str, Any], values: dict[str, Any]) -> Step:
    def filled(text: str) -> str:
        return re.sub(r"\$\{([^}]*)\}", lambda found: str(values[found[1].strip()]), text)

    def paths(*kinds: str) -> list[Path]:
        entries = [entry for kind in kinds for entry in form.get(kind, [])]
        return [Path(filled(e if isinstance(e, str) else next(iter(e)))) for e in entries]

    # what stage `scene` wrote only tells DVC that a robot's files changed: no other stage reads it
    deps = [path for path in paths("deps") if path.parts[0] != "pipeline" and path.parts[:2] != SCENES]
    return Step(name, shlex.split(filled(form["cmd"]))[3:], deps, paths("outs", "metrics", "plots"))
