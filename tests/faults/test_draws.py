"""The table of settings: numbers inside their bounds, in the order of their rows."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.faults.draws import between, computed, either, listed, parameters, signed, unequal
from refdem.faults.settings import SETTINGS

SEEDS = range(50)


def values(draw):
    """What a draw gives at many seeds."""
    return [draw(np.random.default_rng(seed), {}) for seed in SEEDS]


def test_a_number_is_dyadic_and_inside_its_bounds_which_are_reached():
    found = values(between(0.5, 0.75, 8))
    assert set(found) == {Fraction(1, 2), Fraction(5, 8), Fraction(3, 4)}


def test_a_signed_number_has_either_sign_and_the_size_of_its_bounds():
    found = values(signed(1, 2, 4))
    assert {value > 0 for value in found} == {True, False}
    assert all(1 <= abs(value) <= 2 for value in found)


def test_of_two_unequal_numbers_either_may_be_the_larger_one():
    pairs = [tuple(map(Fraction, text.split(","))) for text in values(unequal(1, 2))]
    assert {first > second for first, second in pairs} == {True, False}
    assert all(1.5 <= max(pair) / min(pair) <= 2.5 for pair in pairs)


def test_lists_and_choices_are_text():
    assert set(values(either("1", "3"))) == {"1", "3"}
    assert all(len(text.split(",")) == 3 for text in values(listed(*3 * [between(0, 1)])))


def test_the_last_row_of_a_name_counts_and_the_others_are_drawn_all_the_same():
    plain = (("x", between(0, 1)), ("y", between(0, 1)))
    changed = (*plain, ("x", "7"), ("_double", computed(lambda drawn: 2 * drawn["y"])))
    for seed in SEEDS:
        first = parameters(plain, np.random.default_rng(seed))
        assert parameters(changed, np.random.default_rng(seed)) == {"x": "7", "y": first["y"]}


@pytest.mark.parametrize("name", SETTINGS)
def test_every_row_of_a_setting_is_a_parameter_of_its_case(name):
    setting = SETTINGS[name]
    for seed in SEEDS:
        given = setting.parameters(name, seed)
        assert set(given) <= set(discovery.case(setting.case).at(**given).p.declared)
