"""Bad parameters are told in one sentence that names value, place and remedy."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import Field

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError


class Sizes(params.Section):
    episodes: int = Field(ge=2)
    rate: float = Field(gt=0)


PARAMS = """
seed: 7
heldout_share: 0.25
budget: small
budgets:
  small: {race: {first: 2, most: 5}, rollouts: {episodes: 4, rate: 0.5}}
  large:
    race: {first: 9, most: 9, scenes: {far: {first: 3}}}
    rollouts: {episodes: 400, rate: 0.5, scenes: {far: {episodes: 500}}}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "params.yaml"
    path.write_text(PARAMS, encoding="utf-8")
    return path


def change(file: Path, old: str, new: str) -> Path:
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.with_name("changed.yaml").write_text(text.replace(old, new), encoding="utf-8")
    return file.with_name("changed.yaml")


def test_sections_come_from_the_chosen_budget(file: Path) -> None:
    assert params.budget_section(Sizes, "rollouts", path=file) == Sizes(episodes=4, rate=0.5)
    large = change(file, "budget: small", "budget: large")
    assert params.budget_section(Sizes, "rollouts", path=large).episodes == 400
    assert (params.first_repeats("near", file), params.first_repeats("near", large)) == (2, 9)


def test_a_scene_may_have_sizes_of_its_own(file: Path) -> None:
    large = change(file, "budget: small", "budget: large")
    found = [params.budget_section(Sizes, "rollouts", scene, large) for scene in ("near", "far", None)]
    assert found == [Sizes(episodes=n, rate=0.5) for n in (400, 500, 400)]
    assert [params.first_repeats(scene, large) for scene in ("near", "far")] == [9, 3]
    bad = change(file, "budget: small", "budget: large").with_name("changed.yaml")
    bad.write_text(bad.read_text().replace("{far: {episodes: 500}}", "{far: {episodes: -5}}"))
    with pytest.raises(BelvedereError, match=r"budgets\.large\.rollouts\.episodes = -5"):
        params.budget_section(Sizes, "rollouts", "far", bad)


def test_scalars(file: Path) -> None:
    assert params.seed(file) == 7
    assert params.heldout_share(file) == 0.25


def test_a_changed_file_is_read_anew(file: Path) -> None:
    assert params.seed(file) == 7
    file.write_text(PARAMS.replace("seed: 7", "seed: 80"), encoding="utf-8")
    assert params.seed(file) == 80


def test_a_section_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="frozen"):
        Sizes(episodes=4, rate=1.0).episodes = 5


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("episodes: 4,", "", "budgets.small.rollouts.episodes"),
        ("episodes: 4", "episodes: -4", "budgets.small.rollouts.episodes = -4"),
        ("episodes: 4", "episodes: 2.5", "budgets.small.rollouts.episodes = 2.5"),
        ("episodes: 4", "episodes: many", "budgets.small.rollouts.episodes = 'many'"),
        ("rate: 0.5}}\n  large", "rate: .nan}}\n  large", "budgets.small.rollouts.rate = nan"),
        ("rate: 0.5}}\n  large", "rate: .inf}}\n  large", "budgets.small.rollouts.rate = inf"),
        ("episodes: 4", "episodes: 4, epsiodes: 5", "budgets.small.rollouts.epsiodes"),
        ("budget: small", "budget: huge", "'huge' is unknown; available: large, small"),
        (
            "rollouts: {episodes: 4",
            "rolouts: {episodes: 4",
            "'rollouts' is unknown; available: race, rolouts",
        ),
        ("budgets:", "- budgets:", "not valid YAML"),
    ],
)
def test_a_bad_section_is_told(file: Path, old: str, new: str, told: str) -> None:
    with pytest.raises(BelvedereError) as error:
        params.budget_section(Sizes, "rollouts", path=change(file, old, new))
    assert told in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("race", "told"),
    [
        ("{first: 1, most: 5}", "race.first = 1"),
        ("{first: 2.5, most: 5}", "race.first = 2.5"),
        ("{first: two, most: 5}", "race.first = 'two'"),
        ("{first: 3, most: 41}", "race.most = 41"),
        ("{first: 3, most: 2}", r"most \(2\) must not be less than first \(3\)"),
        ("{first: 3}", "race.most"),
        ("null", "race = None"),
    ],
)
def test_a_bad_race_is_told(file: Path, race: str, told: str) -> None:
    with pytest.raises(BelvedereError, match=told):
        params.first_repeats("near", change(file, "{first: 2, most: 5}", race))


@pytest.mark.parametrize("bad", ["-1", "1.5", "true", "x"])
def test_the_seed_is_a_whole_number(file: Path, bad: str) -> None:
    with pytest.raises(BelvedereError, match="seed = "):
        params.seed(change(file, "seed: 7", f"seed: {bad}"))


@pytest.mark.parametrize("bad", ["0", "1", "-0.1", "true", ".nan", "x"])
def test_the_heldout_share_lies_between_zero_and_one(file: Path, bad: str) -> None:
    with pytest.raises(BelvedereError, match="heldout_share = "):
        params.heldout_share(change(file, "heldout_share: 0.25", f"heldout_share: {bad}"))


@pytest.mark.parametrize("budget", ["{}", "{race: 3, rollouts: 5}", "5"])
def test_a_budget_of_another_shape_is_told(file: Path, budget: str) -> None:
    bad = change(
        file, "small: {race: {first: 2, most: 5}, rollouts: {episodes: 4, rate: 0.5}}", f"small: {budget}"
    )
    with pytest.raises(BelvedereError, match=r"budgets\.small"):
        params.budget_section(Sizes, "rollouts", path=bad)


@pytest.mark.parametrize("top", ["", "- 1", "word"])
def test_a_file_without_a_mapping_is_told(tmp_path: Path, top: str) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(top, encoding="utf-8")
    with pytest.raises(BelvedereError, match="no mapping"):
        params.seed(path)


def test_a_missing_file_says_where_to_run(tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match="run the stage from the repository root"):
        params.seed(tmp_path / "params.yaml")
