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
  small: {repeats: 2, race: {first: 3}, rollouts: {episodes: 4, rate: 0.5}}
  large: {repeats: 9, race: {first: 4}, rollouts: {episodes: 400, rate: 0.5}}
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
    assert (params.repeats(file), params.repeats(large)) == (2, 9)
    assert (params.first_repeats(file), params.first_repeats(large)) == (3, 4)


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
            "'rollouts' is unknown; available: race, repeats, rolouts",
        ),
        ("budgets:", "- budgets:", "not valid YAML"),
    ],
)
def test_a_bad_section_is_told(file: Path, old: str, new: str, told: str) -> None:
    with pytest.raises(BelvedereError) as error:
        params.budget_section(Sizes, "rollouts", path=change(file, old, new))
    assert told in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("bad", ["0", "-1", "2.0", "true", "two", "null"])
def test_repeats_are_a_whole_number_from_one(file: Path, bad: str) -> None:
    with pytest.raises(BelvedereError, match=r"budgets\.small\.repeats = .* from 1 up"):
        params.repeats(change(file, "repeats: 2", f"repeats: {bad}"))


@pytest.mark.parametrize("bad", ["0", "-1", "2.0", "true", "two", "null"])
def test_first_repeats_are_a_whole_number_from_one(file: Path, bad: str) -> None:
    with pytest.raises(BelvedereError, match=r"budgets\.small\.race\.first = .* from 1 up"):
        params.first_repeats(change(file, "first: 3", f"first: {bad}"))


@pytest.mark.parametrize("bad", ["-1", "1.5", "true", "x"])
def test_the_seed_is_a_whole_number(file: Path, bad: str) -> None:
    with pytest.raises(BelvedereError, match="seed = "):
        params.seed(change(file, "seed: 7", f"seed: {bad}"))


@pytest.mark.parametrize("bad", ["0", "1", "-0.1", "true", ".nan", "x"])
def test_the_heldout_share_lies_between_zero_and_one(file: Path, bad: str) -> None:
    with pytest.raises(BelvedereError, match="heldout_share = "):
        params.heldout_share(change(file, "heldout_share: 0.25", f"heldout_share: {bad}"))


@pytest.mark.parametrize("budget", ["{}", "{repeats: 3, rollouts: 5}", "5"])
def test_a_budget_of_another_shape_is_told(file: Path, budget: str) -> None:
    small = "small: {repeats: 2, race: {first: 3}, rollouts: {episodes: 4, rate: 0.5}}"
    bad = change(file, small, f"small: {budget}")
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
