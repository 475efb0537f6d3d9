"""Sessions of the scripted operator, each on a station of its own: synthetic data in their own folder."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.scripted.params import OperatorParams
from pipeline.station.operate import operate
from pipeline.station.params import station_params
from pipeline.station.started import Started
from pipeline.station.study import Study

_STREAM = 102  # of the seeds that DVC's stages do not use


def demonstrate(
    study: Path,
    participants: int,
    seed: int | None,
    scenes: Sequence[str] | None,
    views: Sequence[str] | None,
) -> None:
    """Records sessions in real time.

    Args:
        study: the folder, which holds no person's session.
        participants: how many sessions.
        seed: of plans and of the operator's errors; None takes that of params.yaml.
        scenes, views: as on the command line; None takes those of params.yaml.

    Raises:
        BelvedereError: the folder holds people's sessions, or a station ended early.
    """
    if participants < 1:
        raise BelvedereError(f"--participants {participants} is not valid; it is a whole number from 1 up.")
    root = params.seed() if seed is None else seed
    operator, station = params.section(OperatorParams, "operator"), station_params()
    arguments = ["--operator", "scripted", "--study", str(study), "--port", "0", "--seed", str(root)]
    arguments += [word for scene in scenes or () for word in ("--scene", scene)]
    arguments += ["--views", *views] if views else []
    for _ in range(participants):
        held = Study(study)
        held.require_kind("scripted")
        errors = np.random.SeedSequence(entropy=root, spawn_key=(_STREAM, len(held.plans())))
        with Started(arguments) as station_process:
            rng = np.random.Generator(np.random.PCG64(errors))
            report = asyncio.run(operate(station_process.link, operator, station, rng))
            if not report.done or station_process.wait():
                raise BelvedereError("the station ended before the session did; what it said stands above.")
