"""The rollouts: reproducible, on a grid, and states from which the recorded places follow."""

from __future__ import annotations

import re
import tracemalloc
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml

from pipeline import anchors, rollouts
from pipeline.contract import memory, params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.progress import Progress
from pipeline.sim.episodes import episode_bytes, require_episodes
from pipeline.sim.exploration import roll
from pipeline.sim.params import ExplorationParams
from pipeline.sim.scene import load_scene

GRID = 2.0**-20
ROOT = Path(__file__).resolve().parents[2]


def rolled(name: str) -> dict[str, np.ndarray]:
    process = params.section(ExplorationParams, "rollouts")
    with Progress(50, "rollouts") as progress:
        return roll(load_scene(name), 3, process, np.random.default_rng(5), progress)


def test_the_same_generator_gives_the_same_episodes() -> None:
    first, again = rolled("panda_1dof"), rolled("panda_1dof")
    assert all(np.array_equal(first[name], again[name]) for name in first)


def test_numbers_lie_on_the_grid_and_are_not_all_nought() -> None:
    found = rolled("panda_2dof")
    for name in ("qpos", "tip", "reward"):
        steps = found[name].astype(np.float64) / GRID
        assert np.array_equal(steps, np.round(steps))
        assert np.abs(found[name]).max() > 0.1


def test_the_tip_is_where_the_stored_posture_puts_it() -> None:
    scene, found = load_scene("panda_2dof"), rolled("panda_2dof")
    data = mujoco.MjData(scene.model)
    for episode, frame in ((0, 0), (1, 20), (2, 49)):
        data.qpos[:] = found["qpos"][episode, frame]
        mujoco.mj_kinematics(scene.model, data)
        np.testing.assert_allclose(data.site_xpos[scene.tip_site], found["tip"][episode, frame], atol=1e-5)
        away = np.linalg.norm(found["tip"][episode, frame] - found["target"][episode])
        if frame > 0:  # the reward belongs to the place after the action before
            assert abs(away + found["reward"][episode, frame - 1]) < 1e-5


MOST = {"rollouts": 10**6, "evaluation": 10**4}


def write_params(folder: Path, section: str, **scene: Any) -> None:
    """The repository's params.yaml with as many episodes as may be asked for in a section of budget tiny."""
    tree = yaml.safe_load((ROOT / params.PARAMS_FILE).read_text(encoding="utf-8"))
    tree["budget"], tree["budgets"]["tiny"][section] = "tiny", {"episodes": MOST[section]}
    tree["scenes"]["panda_1dof"] |= scene
    (folder / "params.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8")


@pytest.mark.parametrize("stage", ["rollouts", "evaluation"])
def test_episodes_that_the_machine_cannot_hold_are_refused_before_the_first(
    workplace: Path, stage: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory, "available_bytes", lambda system: 10 * 2**20)
    write_params(workplace, stage)
    with pytest.raises(BelvedereError, match=rf"tiny\.{stage}\.episodes = 10+, .* at most \d+ episodes"):
        if stage == "rollouts":
            rollouts.main(scene="panda_1dof", out=Path("out.json"), store=Path("store"))
        else:
            anchors.main(scene="panda_1dof", out=Path("out.parquet"), metrics=Path("out.json"))
    assert {path.name for path in workplace.iterdir()} == {"params.yaml"}


def test_frames_that_no_machine_holds_are_refused(workplace: Path) -> None:
    write_params(workplace, "rollouts", frames=10**4)
    with pytest.raises(BelvedereError, match=r"of 10000 frames \(scenes\.panda_1dof\.frames\)"):
        rollouts.main(scene="panda_1dof", out=Path("out.json"), store=Path("store"))


def test_as_many_episodes_as_are_said_to_fit_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "available_bytes", lambda system: 10 * 2**20)
    scene = load_scene("fetch_reach")
    with pytest.raises(BelvedereError, match="3 repeats at a time") as told:
        require_episodes(scene, 10**4, "evaluation", 3)
    fit = re.search(r"at most (\d+) episodes", str(told.value))
    assert fit
    require_episodes(scene, int(fit[1]), "evaluation", 3)
    with pytest.raises(BelvedereError):
        require_episodes(scene, int(fit[1]) + 1, "evaluation", 3)


def test_what_episodes_are_said_to_take_is_no_less_than_they_do() -> None:
    """The arrays alone, as Python counts them; MuJoCo's batch is measured beside `_WORLD_BYTES`."""
    scene, process = load_scene("fetch_reach"), params.section(ExplorationParams, "rollouts")

    def peak(episodes: int) -> int:
        tracemalloc.start()
        with Progress(scene.frames, "rollouts") as progress:
            roll(scene, episodes, process, np.random.default_rng(5), progress)
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    peak(2)
    each = (peak(96) - peak(16)) / 80
    assert 0.3 * episode_bytes(scene) < each < episode_bytes(scene)
