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


def phi(low: float, high: float, word: str) -> Step:
    return Step("phi", 30.0, 45.0, (low + high) / 2, low, high, word)


def theta(*words: str) -> list[Step]:
    return [Step("theta", 0.0, 45.0 * (i + 1), 0.0, -0.05, 0.05, word) for i, word in enumerate(words)]


@pytest.mark.parametrize(
    ("steps", "outcome"),
    [
        ([phi(0.1, 0.3, "differs")], "agrees"),
        ([phi(-0.3, -0.1, "differs")], "contradicts"),
        ([phi(-0.05, 0.05, "no difference")], "contradicts"),
        ([phi(-0.2, 0.3, "not separated")], "not separated"),
        ([phi(-0.3, -0.1, "differs").turned()], "contradicts"),  # the same, told the other way round
        (theta("differs"), "not run"),
    ],
)
def test_a_claim_that_one_level_is_higher(steps: list[Step], outcome: str) -> None:
    (found,) = held([HIGHER], {"dqn": Judgement(steps)})
    assert found.outcome == outcome
    if outcome == "contradicts" and steps[0].word == "differs":
        assert (found.low, found.high) == (-0.3, -0.1)


@pytest.mark.parametrize(
    ("words", "outcome"),
    [
        (("no difference", "no difference"), "agrees"),
        (("no difference", "differs"), "contradicts"),
        (("no difference", "not separated"), "not separated"),
    ],
)
def test_a_claim_that_nothing_differs(words: tuple[str, ...], outcome: str) -> None:
    assert held([NONE], {"dqn": Judgement(theta(*words))})[0].outcome == outcome


def test_a_judge_that_did_not_run_or_learned_nothing_says_nothing() -> None:
    assert held([NONE], {})[0].outcome == "not run"
    blind = Judgement(theta("differs"), above_blind=False)
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
