"""How many people: against published tables and against simulated studies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.stats.power import (
    MOST_PEOPLE,
    next_study,
    paired_power,
    people_needed,
    two_sample_power,
)


@pytest.mark.parametrize(("effect", "needed"), [(0.2, 394), (0.5, 64), (0.8, 26)])
def test_two_samples_need_what_cohens_table_says(effect: float, needed: int) -> None:
    """J. Cohen, Statistical Power Analysis, 2nd ed. (1988): two-sided, 5 %, a power of 80 %."""
    assert people_needed(two_sample_power, effect, 0.05, 0.8) == needed


@pytest.mark.parametrize(("effect", "needed"), [(0.2, 199), (0.5, 34), (0.8, 15), (-0.5, 34)])
def test_pairs_need_what_published_programs_say(effect: float, needed: int) -> None:
    assert people_needed(paired_power, effect, 0.05, 0.8) == needed


@pytest.mark.parametrize(
    ("effect", "people", "level"), [(0.6, 12, 0.05), (-0.9, 11, 0.05 / 6), (0.3, 30, 0.05)]
)
def test_power_is_the_share_of_simulated_studies_that_find_it(
    effect: float, people: int, level: float
) -> None:
    rng, studies = np.random.default_rng(people), 8000
    gaps = rng.normal(effect, 1.0, (studies, people))
    share = (stats.ttest_1samp(gaps, 0.0, axis=1).pvalue < level).mean()
    assert paired_power(effect, people, level) == pytest.approx(share, abs=0.02)
    one, other = rng.normal(effect, 1.0, (studies, people)), rng.normal(0.0, 1.0, (studies, people))
    share = (stats.ttest_ind(one, other, axis=1).pvalue < level).mean()
    assert two_sample_power(effect, people, level) == pytest.approx(share, abs=0.02)


def test_without_an_effect_power_is_the_level_and_nobody_suffices() -> None:
    assert paired_power(0.0, 20, 0.05) == pytest.approx(0.05)
    assert people_needed(paired_power, 0.0, 0.05, 0.8) is None
    assert people_needed(paired_power, 0.001, 0.05, 0.8) is None
    assert paired_power(0.001, MOST_PEOPLE, 0.05) < 0.8


@pytest.mark.parametrize("effect", [0.05, 0.31, 1.7, 30.0])
def test_fewest_means_that_one_fewer_is_too_few(effect: float) -> None:
    needed = people_needed(paired_power, effect, 0.01, 0.9)
    assert needed is not None and paired_power(effect, needed, 0.01) >= 0.9
    assert needed == 2 or paired_power(effect, needed - 1, 0.01) < 0.9


def test_the_next_study() -> None:
    found = next_study(-0.7, -1.3, -0.2, people=11, level=0.05, power=0.8)
    assert found.people == people_needed(paired_power, 0.7, 0.05, 0.8) == 19
    assert found.more == 8
    assert found.cautious == people_needed(paired_power, 0.2, 0.05, 0.8)
    assert next_study(-0.7, -1.3, 0.1, 11, 0.05, 0.8).cautious is None
    assert next_study(2.0, 1.0, 3.0, 40, 0.05, 0.8).more == 0
    assert next_study(0.001, -0.5, 0.5, 40, 0.05, 0.8).more is None
