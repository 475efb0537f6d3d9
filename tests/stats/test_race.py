"""The race's error, its looks and its replay, against least squares, SciPy and tables worked by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.blocks import two_way
from pipeline.stats.race import Error, Rules, look, no_error, pair_variances, with_repeat
from pipeline.stats.replay import replay

RULES = Rules(first=3, most=20, tolerance=0.05, probability=0.008)


def table(views: int, repeats: int, seed: int, sd: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return sd * (rng.normal(size=repeats) + rng.normal(size=(views, repeats)))


def error_of(values: np.ndarray, blocks: list[np.ndarray]) -> Error:
    """The error after all blocks; views without a repeat have NaN there."""
    error = no_error()
    for repeats, active in enumerate(blocks, start=1):
        error = with_repeat(error, values[:, :repeats], active)
    return error


def test_without_elimination_the_error_is_the_residual_of_a_block_design() -> None:
    values = table(4, 6, 1)
    found = error_of(values, [np.ones(4, dtype=bool)] * 6)
    residual = two_way(values).residual
    assert residual is not None
    assert (float(found.df), float(found.variance) ** 0.5) == (residual.df, pytest.approx(residual.sd))


def test_of_a_ragged_table_it_is_the_residual_of_least_squares() -> None:
    """Views 2 and 3 stop after 3 and 4 repeats: the model y = view + repeat fits what is there."""
    values, counts = table(4, 6, 2), np.array([6, 6, 3, 4])
    there = np.arange(6) < counts[:, None]
    found = error_of(np.where(there, values, np.nan), list(there.T))
    view, repeat = np.nonzero(there)
    design = np.concatenate([np.eye(4)[view], np.eye(6)[repeat][:, 1:]], axis=1)
    y = values[view, repeat]
    left = y - design @ np.linalg.lstsq(design, y, rcond=None)[0]
    assert float(found.df) == len(y) - design.shape[1]
    assert float(found.squares) == pytest.approx(float(left @ left))


def test_two_views_race_by_the_paired_t_test() -> None:
    values = table(2, 5, 3)
    found = look(values, np.ones(2, dtype=bool), error_of(values, [np.ones(2, dtype=bool)] * 5), 2, 0.008)
    paired = stats.ttest_rel(values[0], values[1], alternative="greater").confidence_interval(1 - 0.008)
    gap = values.mean(axis=1) @ [1, -1]
    assert gap - float(found.half_widths[0, 1]) == pytest.approx(paired.low)


def test_a_pairs_variance_is_its_own_shrunk_and_never_below_the_pooled_one() -> None:
    values = table(3, 8, 4)
    values[2] *= 5
    error = error_of(values, [np.ones(3, dtype=bool)] * 8)
    found, pooled = pair_variances(values, error), 2 * float(error.variance)
    own = {(i, j): (values[i] - values[j]).var(ddof=1) for i in range(3) for j in range(3)}
    assert own[0, 1] < pooled and found[0, 1] == pooled
    assert found[0, 2] == pytest.approx((4 * pooled + 7 * own[0, 2]) / 11)
    assert pooled < found[0, 2] < own[0, 2]
    np.testing.assert_array_equal(found, found.T)


def test_what_repeats_share_and_where_scores_start_changes_nothing() -> None:
    values = table(3, 6, 5) * 0.02 + np.array([[0.5], [0.46], [0.3]])
    moved = values + np.arange(6) + 7
    here, there = replay(list(values), RULES), replay(list(moved), RULES)
    assert (here.state, here.out, here.leader) == (there.state, there.out, there.leader)
    assert here.last.within == pytest.approx(there.last.within)
    order = [2, 0, 1]
    turned = replay([values[view] for view in order], RULES)
    assert {order[view]: at for view, at in turned.out.items()} == here.out
    assert turned.last.within == pytest.approx(here.last.within)


def test_a_clear_winner_is_left_alone_at_the_first_look() -> None:
    values = table(3, 3, 6, 0.01) + np.array([[0.2], [0.8], [0.4]])
    race = replay(list(values), RULES)
    assert (race.state, race.leader, race.active) == ("alone", 1, [1])
    assert race.out == {0: 3, 2: 3} and race.last.within == 0
    lead, most = race.lead()
    assert 0 < lead < (most or 0) and lead == pytest.approx(0.4, abs=0.05)


def test_views_that_are_alike_end_at_the_tolerance_and_later_repeats_are_not_looked_at() -> None:
    values = table(2, 20, 7, 0.01) + 0.5
    race = replay(list(values), RULES)
    assert race.state == "tolerance" and race.last.within <= RULES.tolerance
    fewer = replay(list(values[:, : race.last.repeats]), RULES)
    assert fewer.state == "tolerance" and len(fewer.looks) == len(race.looks)


def test_a_race_is_open_until_its_active_views_have_the_next_repeat() -> None:
    values = list(table(3, 5, 8, 0.05) + np.array([[0.6], [0.6], [-0.5]]))
    rules = Rules(first=3, most=20, tolerance=0.001, probability=0.008)
    race = replay([values[0], values[1], values[2][:3]], rules)
    assert race.out == {2: 3}
    assert (race.state, race.last.repeats) == ("open", 5)
    waiting = replay([values[0], values[1][:4], values[2]], rules)
    assert (waiting.state, waiting.last.repeats) == ("open", 4)  # the leader's fifth waits for its rival's
    assert race.shared(0, 2).repeats == 3 and race.between(0, 2, 0.95).repeats == 3
    assert race.forecast() % 2 == 0 and race.forecast() > 0


def test_after_the_most_repeats_it_has_ended() -> None:
    race = replay(list(table(2, 6, 9, 1.0)), Rules(3, 6, 0.05, 0.008))
    assert (race.state, race.last.repeats) == ("ended", 6)
    assert race.last.within > 0.05


def test_the_forecast_is_the_repeat_at_which_u_meets_the_tolerance() -> None:
    """Had the next repeats the same means and variances, U would be at the tolerance then, but for c."""
    race = replay(list(table(2, 6, 9)), Rules(3, 6, 0.05, 0.008))
    a, b = race.active
    needed = race.forecast() / 2 + 6
    half = float(race.last.half_widths[a, b]) * (6 / needed) ** 0.5
    assert half - (race.last.means[a] - race.last.means[b]) <= 0.05
    before = float(race.last.half_widths[a, b]) * (6 / (needed - 1)) ** 0.5
    assert before - (race.last.means[a] - race.last.means[b]) > 0.05


def test_one_view_is_alone_and_equal_numbers_are_a_tie() -> None:
    alone = replay([np.array([0.1, 0.2, 0.3])], RULES)
    assert (alone.state, alone.lead()) == ("alone", (0.0, None)) and alone.last.within == 0
    tie = replay([np.full(3, 0.5)] * 2, RULES)
    assert tie.state == "tolerance" and tie.last.within == 0
    apart = replay([np.full(3, 0.5), np.full(3, 0.4)], RULES)
    assert apart.state == "alone"


def test_a_pairs_own_interval_is_the_paired_t_interval() -> None:
    values = table(2, 5, 11)
    found = replay(list(values), Rules(3, 5, 0.0, 0.008)).between(0, 1, 0.95)
    expected = stats.ttest_rel(values[0][: found.repeats], values[1][: found.repeats]).confidence_interval(
        0.95
    )
    assert (found.low, found.high) == (pytest.approx(expected.low), pytest.approx(expected.high))
