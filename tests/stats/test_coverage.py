"""The race's certainty by simulation; the committed table is what the code gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from benchmarks.coverage import RULES, SITUATIONS, VIEWS, row
from pipeline.stats.coverage import POPULATIONS, draw, normal, run
from pipeline.stats.race import Rules
from pipeline.stats.replay import replay
from pipeline.stats.tails import tail

ROOT = Path(__file__).resolve().parents[2]
UNTIL_THE_END = 0.0  # a tolerance that no race meets while two views are left


@pytest.mark.parametrize("views", [2, 3, 6])
def test_of_equal_views_a_best_one_is_eliminated_in_no_more_than_one_race_in_twenty(views: int) -> None:
    rng, most = np.random.default_rng(1), 20
    rules = Rules(2, most, UNTIL_THE_END, tail(0.95, most))
    found = run(draw(normal, views, 0.0, 1.0, 4000, most, rng), np.zeros(views), rules)
    assert found.wrong.mean() <= 0.055


@pytest.mark.parametrize(("views", "gap"), [(3, 0.05), (4, 0.1)])
def test_the_best_view_stays_and_the_leads_interval_holds(views: int, gap: float) -> None:
    rng, means = np.random.default_rng(2), np.array([gap, *np.zeros(views - 1)])
    found = run(draw(normal, views, gap, 0.06, 3000, RULES.most, rng), means, RULES)
    assert found.wrong.mean() <= 0.05
    assert found.covered.mean() >= 0.95
    assert (found.trainings < views * found.repeats).any()  # views were eliminated on the way


def test_unlike_variances_do_no_harm() -> None:
    """The best view scatters twice as much as the others."""
    rng, means = np.random.default_rng(3), np.array([0.03, 0.0, 0.0])
    values = draw(normal, 3, 0.03, 0.05, 3000, RULES.most, rng)
    values[:, 0] += 0.05 * 3**0.5 * rng.standard_normal((3000, RULES.most))
    found = run(values, means, RULES)
    assert found.wrong.mean() <= 0.055 and found.covered.mean() >= 0.945


def test_all_races_at_once_are_the_races_one_by_one() -> None:
    values = draw(normal, 4, 0.05, 0.08, 40, RULES.most, np.random.default_rng(4))
    together = run(values, np.array([0.05, 0, 0, 0]), RULES)
    for index, table in enumerate(values):
        race = replay(list(table), RULES)
        counts = [race.out.get(view, race.last.repeats) for view in range(4)]
        assert (together.leader[index], together.repeats[index]) == (race.leader, race.last.repeats)
        assert together.trainings[index] == sum(counts)
        assert together.within[index] == pytest.approx(float(race.last.within))
        assert together.high[index] == pytest.approx(race.lead()[1])
        ragged = replay([own[:count] for own, count in zip(table, counts, strict=True)], RULES)
        assert (ragged.state, ragged.out, len(ragged.looks)) == (race.state, race.out, len(race.looks))


def test_the_populations_have_mean_zero() -> None:
    for name, population in POPULATIONS.items():
        draws = population(np.random.default_rng(3), (400_000,))
        assert abs(draws.mean()) < 5 * draws.std() / len(draws) ** 0.5, name


def test_the_committed_table_is_what_the_code_gives() -> None:
    rows = pl.read_csv(ROOT / "data/reference/coverage.csv").to_dicts()
    assert len(rows) == len(POPULATIONS) * len(VIEWS) * len(SITUATIONS)
    for shown in rows[::10]:
        gap = SITUATIONS[shown["situation"]]
        found = row(POPULATIONS[shown["population"]], shown["views"], gap, 1500, 4)
        assert found["wrong"] == pytest.approx(shown["wrong"], abs=0.02)
        assert found["covered"] == pytest.approx(shown["covered"], abs=0.02)
        assert found["trainings"] == pytest.approx(shown["trainings"], rel=0.05)


def test_the_committed_races_err_as_seldom_as_they_say_but_where_trainings_fail() -> None:
    rows = pl.read_csv(ROOT / "data/reference/coverage.csv").filter(pl.col("population") == "normal")
    assert rows["wrong"].max() <= 0.05 and rows["covered"].min() >= 0.95
