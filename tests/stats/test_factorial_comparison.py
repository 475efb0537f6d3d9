"""The comparison of judges, on tables whose answer is known."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.stats.branches import Results
from pipeline.stats.claims import Claim
from pipeline.stats.dqn import DqnResults, read_dqn
from pipeline.stats.factorial_comparison import comparison
from pipeline.stats.params import RankingParams
from pipeline.storage.artefacts import write_json
from pipeline.storage.sight import Sight

ANGLES = [(t, p) for p in (30.0, 45.0) for t in (0.0, 45.0, 90.0)]
KEYS = [f"reach-{letter}" for letter in "abcdef"]
METHOD = RankingParams(confidence=0.95, tolerance=0.05, equivalence_margin=0.1)
SEEN = Sight(0.02, 0.2, [])
CLAIMS = [
    Claim(
        section="III-B",
        scene="reach",
        judge=judge,
        factor="phi",
        first_deg=30,
        second_deg=45,
        finding="higher",
    )
    for judge in ("world model", "dqn", "world model over dqn")
]


def returns(effect_of_phi: float, level: float, repeats: int, seed: int) -> np.ndarray:
    """(view, repeat), blind at -10 and expert at 0: scores are 1 + return / 10."""
    noise = np.random.default_rng(seed).normal(size=(6, repeats)) * 0.1
    return level + noise + np.array([effect_of_phi * (p == 30.0) for _, p in ANGLES])[:, None]


def results(values: np.ndarray, unseen: str = "") -> Results:
    """Anchors of 3 repeats; the judge cannot see at the view of key ``unseen``."""
    branches = {k: Viewpoint(scene="reach", theta=t, phi=p) for k, (t, p) in zip(KEYS, ANGLES, strict=True)}
    anchors = {n: np.full(3, v) for n, v in {"no_op": -11.0, "blind": -10.0, "expert": 0.0}.items()}
    sight = {key: Sight(0.19, 0.2, ["tip"]) if key == unseen else SEEN for key in KEYS}
    returned = dict(zip(KEYS, values, strict=True))
    return Results(branches, {key: [] for key in KEYS}, returned, sight, anchors, {})


def outcomes(content: dict) -> list[str]:
    return [claim["outcome"] for claim in content["claims"]]


def test_without_networks_only_the_world_model_speaks() -> None:
    content = comparison(results(returns(3.0, -6.0, 4, 1)), None, CLAIMS, METHOD)
    assert content["dqn"] is None and content["judges"] is None
    assert outcomes(content) == ["agrees", "not run", "not run"]
    (phi,) = [effect for effect in content["factorial"]["effects"] if effect["factor"] == "phi"]
    assert (phi["first_deg"], phi["second_deg"]) == (30.0, 45.0)
    assert phi["difference"] == pytest.approx(0.3, abs=0.02)


def test_judges_of_which_one_sees_tilt_and_one_does_not() -> None:
    dqn = DqnResults(KEYS, returns(0.0, -5.0, 3, 2), np.full(3, -1.0))
    content = comparison(results(returns(3.0, -6.0, 4, 1)), dqn, CLAIMS, METHOD)
    assert outcomes(content) == ["agrees", "not settled", "agrees"]
    assert [claim["size"] for claim in content["claims"]] == ["may matter", "below 0.1", None]
    assert content["judges"]["test"]["p"] < 0.001
    view = content["dqn"]["viewpoints"]["reach-a"]
    assert view["score_mean"] == pytest.approx(1 + view["return_mean"] / 10)
    assert view["score_of_restricted_mean"] == pytest.approx((view["return_mean"] + 10) / 9)


def test_the_grids_common_repeats_are_what_is_compared() -> None:
    """A repeat that only some views have, and a view beside the grid, change nothing."""
    few = returns(3.0, -6.0, 3, 1)
    whole, ragged = results(few), results(few)
    ragged.returns[KEYS[0]] = np.append(few[0], -9.0)
    ragged.branches["study"] = Viewpoint(scene="reach", theta=20, phi=37)
    ragged.returns["study"], ragged.sight["study"] = np.array([-1.0, -2.0]), Sight(0.19, 0.2, ["tip"])
    expected, found = (comparison(each, None, CLAIMS, METHOD) for each in (whole, ragged))
    assert found == expected


def test_a_claim_on_a_view_at_which_the_judge_cannot_see_is_not_told() -> None:
    dqn = DqnResults(KEYS, returns(0.0, -5.0, 3, 2), np.full(3, -1.0))
    content = comparison(results(returns(3.0, -6.0, 4, 1), unseen=KEYS[1]), dqn, CLAIMS, METHOD)
    assert outcomes(content) == ["cannot see", "not settled", "cannot see"]


def test_networks_that_learned_nothing_are_no_judges() -> None:
    dqn = DqnResults(KEYS, returns(0.0, -10.5, 3, 2), np.full(3, -1.0))
    content = comparison(results(returns(3.0, -6.0, 4, 1)), dqn, CLAIMS, METHOD)
    assert outcomes(content) == ["agrees", "not above blind", "not above blind"]


@pytest.mark.parametrize("repeats", [1, 2, 5, 9])
def test_networks_may_have_any_number_of_repeats(repeats: int) -> None:
    """More than the world model's 4 and the anchors' 3, or fewer."""
    dqn = DqnResults(KEYS, returns(3.0, -5.0, repeats, 2), np.full(repeats, -1.0))
    content = comparison(results(returns(3.0, -6.0, 4, 1)), dqn, CLAIMS, METHOD)
    assert content["dqn"]["repeats"] == repeats
    view = content["dqn"]["viewpoints"]["reach-b"]
    assert view["return_mean"] == pytest.approx(dqn.returns[1].mean())
    assert (content["judges"] is None) == (repeats == 1)


@pytest.mark.parametrize("shifts", [(0.0, 0.0, 0.0), (0.1, 0.2, 0.7)])
@pytest.mark.parametrize("both", [False, True])
def test_judges_whose_repeats_leave_no_error_are_not_tested(
    tmp_path: Path, shifts: tuple[float, ...], both: bool
) -> None:
    """A network that does the same from every view: its differences are 0, and no number is infinite."""
    same = np.tile(-5.0 + np.array(shifts), (6, 1))
    dqn = DqnResults(KEYS, same, np.full(3, -1.0))
    ours = same if both else returns(3.0, -6.0, 3, 1)
    with np.errstate(all="raise"):
        content = comparison(results(ours), dqn, CLAIMS, METHOD)
    assert content["dqn"]["factorial"]["tests"] == {}
    assert all(effect["difference"] == 0 for effect in content["dqn"]["factorial"]["effects"])
    assert all(effect["word"] == "no difference" for effect in content["dqn"]["factorial"]["effects"])
    assert (content["judges"]["test"] is None) == both
    write_json(tmp_path / "ranking.json", content)


def write(folder: Path, key: str, rows: list[dict]) -> None:
    path = folder / key / "dqn.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({"repeats": rows}))


def test_what_is_read(tmp_path: Path) -> None:
    assert read_dqn(tmp_path, KEYS) is None
    write(tmp_path, KEYS[0], [])
    assert read_dqn(tmp_path, KEYS) is None
    rows = [{"repeat": r, "return": -3.0 - r, "expert_return": -1.0 - r} for r in (1, 0)]
    write(tmp_path, KEYS[1], rows)
    found = read_dqn(tmp_path, KEYS)
    assert found is not None and found.keys == [KEYS[1]]
    np.testing.assert_array_equal(found.returns, [[-3.0, -4.0]])
    np.testing.assert_array_equal(found.restricted_expert, [-1.0, -2.0])
    write(tmp_path, KEYS[2], rows[:1])
    with pytest.raises(BelvedereError, match="different numbers of repeats"):
        read_dqn(tmp_path, KEYS)
    write(tmp_path, KEYS[3], [{"repeat": 0, "return": "x", "expert_return": 1}])
    with pytest.raises(BelvedereError, match=f"dqn@{KEYS[3]}"):
        read_dqn(tmp_path, KEYS)
