"""A made-up study in a folder: the tables and pictures that the page reads, with numbers of no meaning."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import polars as pl
import yaml
from PIL import Image, ImageDraw

from pipeline import people, trials
from pipeline.reporting.results import Coverage
from pipeline.reporting.tried import COLUMNS
from pipeline.storage.artefacts import write_json
from tests.stages.report_rankings import (
    BLIND,
    EXPERT,
    FIRST,
    MOST,
    NO_OP,
    PROVENANCE,
    REPOSITORY,
    Angles,
    ranking,
)
from tests.study.sessions import write_sessions

VIEWS: dict[str, dict[str, tuple[float, float]]] = {
    "panda_1dof": {"panda_1dof-a": (90, 45), "panda_1dof-b": (90, 30)},
    "panda_2dof": {"panda_2dof-a": (0, 0), "panda_2dof-b": (90, 0)},
    "panda_2dof_obstacle": {"panda_2dof_obstacle-a": (0, 0), "panda_2dof_obstacle-b": (90, 0)},
    "fetch_reach": {
        f"fetch_reach-{letter}": (theta, phi)
        for letter, (phi, theta) in zip(
            "abcdef", [(p, t) for p in (30, 45) for t in (0, 45, 90)], strict=True
        )
    },
}
THINGS = ("tip", "target", "tip_to_target")
PROBES = [f"probe_{kind}_{what}_m" for kind in ("linear", "mlp") for what in THINGS]
SHARES = ["target_seen_share", "frames_target_hidden_share"]
VAE = ["reconstruction_error", "kl_nats", "active_dimensions"]
LEVELS = (-3.2, -3.28, -3.9, -4.2, -5.0, -5.2, -5.4)  # mean returns of a scene's views, in their order
REPEATS = (5, 4, 3, 3, 3, 3, 3)  # of a scene's views, in their order


def write_study(
    folder: Path,
    scenes: Mapping[str, Angles],
    study: tuple[str, float, float] | None = ("panda_2dof", 45, 15),
    most: int = MOST,
    opened: tuple[str, ...] = (),
    participants: int = 0,
) -> None:
    """Writes all that the stage `report` reads.

    Args:
        folder: the working directory.
        scenes: of each its views.
        study: scene, θ and φ of the viewpoint under study.
        most: repeats that no view has more of.
        opened: scenes whose race is not over.
        participants: of a made-up study of the scripted operator's.
    """
    rng = np.random.default_rng(7)
    _write_params(folder, scenes)
    for scene, candidates in scenes.items():
        views = dict(candidates)
        if study and scene == study[0]:
            views["study"] = study[1:]
        _write_anchors(folder, scene)
        returns = {}
        for place, (key, angles) in enumerate(views.items()):
            level = LEVELS[place]
            returns[key] = (level + rng.normal(0, 0.12, min(most, REPEATS[place]))).tolist()
            _write_branch(folder / "reports/branches" / scene / key, scene, angles, place, returns[key], rng)
            write_pictures(folder / "reports/pictures" / key, angles)
        content = ranking(scene, views, returns, opened=scene in opened)
        write_json(folder / f"reports/rankings/{scene}.json", content)
    write_people(folder, participants)
    _write_record(folder / "reports", list(scenes))
    (folder / "reports/searches").mkdir()
    (folder / "reports/ablations").mkdir()
    _write_coverage(folder / "data/coverage.csv")
    pl.DataFrame(schema=COLUMNS).write_csv(folder / "data/tried.csv")


def _write_record(reports: Path, scenes: list[str]) -> None:
    """A record of the same numbers, as if its controllers had been searched for from zero."""
    for part in ("rankings", "branches", "anchors"):
        shutil.copytree(reports / part, reports / "paper" / part)
    about = {"scenes": scenes, "changes": ["controller.first=zero"], "commit": "0123abc"}
    write_json(reports / "paper" / "about.json", {**about, "date": "2026-11-27"})


def write_people(folder: Path, participants: int = 0, operator: str = "scripted") -> None:
    """What `trials` and `people` make of made-up sessions, held against the rankings that are there."""
    study = folder / "data/sessions"
    study.mkdir(parents=True, exist_ok=True)
    if participants:
        write_sessions(study, participants, seed=5, operator=operator)
    joined = folder / "data/trials.parquet"
    trials.main(study=study, out=joined, excluded=folder / "data/excluded.csv")
    subjects, rankings = REPOSITORY / "data/reference/subjects.csv", folder / "reports/rankings"
    out, points = folder / "reports/people.json", folder / "data/people"
    people.main(trials=joined, subjects=subjects, rankings=rankings, out=out, points=points)


def _write_params(folder: Path, scenes: Mapping[str, Angles]) -> None:
    episodes = {"episodes": 30, "scenes": {"fetch_reach": {"episodes": 20}}}
    sizes = {"race": {"first": FIRST, "most": MOST}, "rollouts": episodes, "vae": {"epochs": 20}}
    tree = {
        "budget": "quick",
        "seed": 1,
        "heldout_share": 0.1,
        "sight_share": 0.5,
        "controller": {"first": "rewards"},
        "rollouts": {},
        "vae": {},
        "mdnrnn": {},
        "scenes": {scene: {"frames": 50} for scene in scenes},
        "people": yaml.safe_load((REPOSITORY / "params.yaml").read_text(encoding="utf-8"))["people"],
        "budgets": {"quick": sizes},
    }
    (folder / "params.yaml").write_text(yaml.safe_dump(tree, sort_keys=False))


def _write_coverage(path: Path) -> None:
    path.parent.mkdir(exist_ok=True)
    rows = [
        {"population": population, "views": views, "situation": situation, "runs": 2000,
         "wrong": 0.021 + views / 1000, "covered": 0.991 - views / 1000, "trainings": 11.37 * views}
        for population in ("normal", "skewed")
        for views in (2, 6)
        for situation in ("all alike", "one leads by 0.1")
    ]  # fmt: skip
    pl.DataFrame(rows).select(*Coverage.model_fields).write_csv(path)


def _write_anchors(folder: Path, scene: str) -> None:
    means = {
        "no_op_mean": NO_OP,
        "blind_mean": BLIND,
        "expert_mean": EXPERT,
        "expert_within_2cm_share_mean": 1.0,
    }
    write_json(
        folder / f"reports/anchors/{scene}.json",
        {"scene": scene, **means, "repeats": [], "provenance": PROVENANCE},
    )


def _write_branch(
    folder: Path,
    scene: str,
    angles: tuple[float, float],
    place: int,
    returns: list[float],
    rng: np.random.Generator,
) -> None:
    head = {"scene": scene, "theta_deg": angles[0], "phi_deg": angles[1]}
    write_json(
        folder / "evaluation.json",
        {**head, "return_mean": float(np.mean(returns)), "final_distance_m_mean": 0.02 + 0.021 * place,
         "within_2cm_share_mean": 0.71 - 0.1 * place, "within_5cm_share_mean": 0.97 - 0.1 * place,
         "repeats": [{"repeat": r, "return": value} for r, value in enumerate(returns)],
         "provenance": PROVENANCE},
    )  # fmt: skip
    times = {f"time_s_{kind}": 3.1 + place for kind in ("mean", "median")}
    distances = {f"distance_m_{kind}": 0.0021 + place / 1000 for kind in ("mean", "median")}
    ended = {"trials": 64, "grasped_share": 1 - place / 20, "look_m": {"y": 0.0017, "z": 0.0121}}
    write_json(folder / "operator.json", {**head, **ended, **times, **distances})
    vae = {f"{name}_mean": float(rng.uniform(0.004, 0.06)) for name in PROBES}
    vae |= {f"guess_{what}_m_mean": float(rng.uniform(0.1, 0.3)) for what in THINGS}
    vae |= {f"{name}_mean": float(rng.uniform(0, 1)) for name in SHARES}
    vae |= {f"{name}_mean": float(rng.uniform(8, 40)) for name in VAE}
    write_json(folder / "vae.json", {**head, **vae, "repeats": []})
    nll = {
        "heldout_nll_nats_per_latent_mean": 12.3 + place,
        "heldout_nll_of_last_frame_nats_per_latent_mean": 20.6,
    }
    write_json(folder / "mdnrnn.json", {**head, **nll, "repeats": []})
    _curve(returns, rng).write_csv(folder / "controller.csv")


def _curve(returns: list[float], rng: np.random.Generator) -> pl.DataFrame:
    """From a start of some use, fast at first, to what the evaluation says."""
    generation = np.arange(16)
    tables = []
    for r, end in enumerate(returns):
        mean = end - 1.1 * np.exp(-generation / 4) + rng.normal(0, 0.05, len(generation))
        columns = {"repeat": r, "generation": generation, "frames": 6400 * (generation + 1)}
        tables.append(pl.DataFrame({**columns, "mean": mean, "best": mean + 0.1}))
    return pl.concat(tables)


def write_pictures(folder: Path, angles: tuple[float, float]) -> None:
    """A branch's pictures: a bent stick that reaches for a red disc."""
    (folder / "view").mkdir(parents=True)
    large = _drawn(640, 480, angles, 0.3)
    large.save(folder / "view" / "view.png")
    large.crop((80, 0, 560, 480)).resize((64, 64)).save(folder / "view" / "view_64.png")
    grid = Image.new("RGB", (512, 128))
    for column in range(8):
        for row in range(2):
            grid.paste(_drawn(64, 64, angles, column / 8), (64 * column, 64 * row))
    grid.save(folder / "reconstructions.png")
    frames = [_drawn(128, 128, angles, step / 12) for step in range(12)]
    frames[0].save(folder / "clip.webp", save_all=True, append_images=frames[1:], duration=40, loop=0)


def _drawn(width: int, height: int, angles: tuple[float, float], reach: float) -> Image.Image:
    image = Image.new("RGB", (width, height), (96, 110, 128))
    pen = ImageDraw.Draw(image)
    w, h = width, height
    pen.rectangle((0, 0.78 * h, w, h), fill=(196, 180, 150))
    elbow = (0.35 * w + angles[0] / 400 * w, 0.3 * h)
    tip = (elbow[0] + 0.1 * w + reach * 0.2 * w, 0.45 * h + reach * 0.15 * h)
    pen.line([(0.3 * w, 0.8 * h), elbow, tip], fill=(238, 238, 240), width=max(2, w // 16), joint="curve")
    pen.ellipse((0.62 * w, 0.55 * h, 0.7 * w, 0.55 * h + 0.08 * w), fill=(214, 48, 42))
    return image
