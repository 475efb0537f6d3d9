"""Claims against made-up judgements, and the repository's own list."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from pipeline.contract.errors import BelvedereError
from pipeline.stats.claims import Claim, Judgement, Step, held, read_claims

ROOT = Path(__file__).resolve().parents[2]
HIGHER = Claim(
    section="III-B", scene="reach", judge="dqn", factor="phi", first_deg=30, second_deg=45, finding="higher"
)
NONE = Claim(section="III-B", scene="reach", judge="dqn", factor="theta", finding="none")


MARGIN = 0.1


def step(factor: str, second_deg: float, low: float, high: float) -> Step:
    """With a 90 % interval of four fifths of its interval's width."""
    middle, narrow = (low + high) / 2, 0.4 * (high - low)
    return Step(factor, 30.0, second_deg, middle, low, high, middle - narrow, middle + narrow)


def phi(low: float, high: float) -> Step:
    return step("phi", 45.0, low, high)


def theta(*bounds: tuple[float, float]) -> list[Step]:
    return [step("theta", 45.0 * (i + 1), low, high) for i, (low, high) in enumerate(bounds)]


@pytest.mark.parametrize(
    ("found", "direction", "size", "outcome"),
    [
        (phi(0.1, 0.3), "same", "may matter", "agrees"),
        (phi(0.01, 0.05), "same", "below 0.1", "agrees"),
        (phi(-0.3, -0.1), "opposite", "may matter", "contradicts"),
        (phi(-0.3, -0.1).turned().turned(), "opposite", "may matter", "contradicts"),
        (phi(-0.05, 0.05), "not settled, leans the other way", "below 0.1", "not settled"),
        (phi(-0.2, 0.3), "not settled, leans the same way", "may matter", "not settled"),
        (phi(-0.3, 0.2), "not settled, leans the other way", "may matter", "not settled"),
    ],
)
def test_a_claim_that_one_level_is_higher(found: Step, direction: str, size: str, outcome: str) -> None:
    for told in (found, found.turned()):  # the same, told the other way round
        (held_,) = held([HIGHER], {"dqn": Judgement([told], MARGIN)})
        assert (held_.direction, held_.size, held_.outcome) == (direction, size, outcome)
        assert (held_.low, held_.high) == (pytest.approx(found.low), pytest.approx(found.high))


@pytest.mark.parametrize(
    ("bounds", "size", "outcome"),
    [
        ([(-0.05, 0.05), (0.01, 0.08)], "below 0.1", "agrees"),
        ([(-0.05, 0.05), (0.11, 0.3)], "may matter", "contradicts"),
        ([(-0.05, 0.05), (-0.3, -0.11)], "may matter", "contradicts"),
        ([(-0.05, 0.05), (0.05, 0.3)], "may matter", "not settled"),
    ],
)
def test_a_claim_that_nothing_differs(bounds: list[tuple[float, float]], size: str, outcome: str) -> None:
    (found,) = held([NONE], {"dqn": Judgement(theta(*bounds), MARGIN)})
    assert (found.direction, found.size, found.outcome) == (None, size, outcome)


def test_a_view_at_which_the_judge_cannot_see_gates_the_claims_on_it() -> None:
    steps = [phi(0.1, 0.3), *theta((0.2, 0.3))]
    for unseen, of_phi in (((0.0, 30.0), "cannot see"), ((0.0, 45.0), "cannot see"), ((0.0, 60.0), "agrees")):
        judge = Judgement(steps, MARGIN, unseen=[unseen])
        assert [found.outcome for found in held([HIGHER, NONE], {"dqn": judge})] == [of_phi, "cannot see"]


def test_of_an_interaction_no_size_is_told() -> None:
    found = held([HIGHER], {"dqn": Judgement([Step("phi", 30.0, 45.0, 0.2, 0.1, 0.3, None, None)], MARGIN)})
    assert [(row.direction, row.size, row.outcome) for row in found] == [("same", None, "agrees")]


def test_a_judge_that_did_not_run_or_learned_nothing_says_nothing() -> None:
    assert held([NONE], {})[0].outcome == "not run"
    assert held([HIGHER], {"dqn": Judgement(theta((0.2, 0.3)), MARGIN)})[0].outcome == "not run"
    blind = Judgement(theta((0.2, 0.3)), MARGIN, above_blind=False)
    assert held([NONE], {"dqn": blind})[0].outcome == "not above blind"


def test_the_repositorys_claims_name_its_scenes() -> None:
    claims = read_claims(ROOT / "data/reference/claims.yaml")
    scenes = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))["scenes"]
    assert {claim.scene for claim in claims} == set(scenes)
    assert all((claim.finding == "higher") == (claim.first_deg is not None) for claim in claims)


@pytest.mark.parametrize("text", ["- {section: III}", "a: [", "nothing"])
def test_a_foreign_file_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "claims.yaml"
    path.write_text(text)
    with pytest.raises(BelvedereError, match=r"claims\.yaml holds no list of claims"):
        read_claims(path)
    with pytest.raises(BelvedereError, match="is missing"):
        read_claims(tmp_path / "none.yaml")
