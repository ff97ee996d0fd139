"""Cosines of multiples of an angle are those of the trigonometric identities."""

import math

import pytest

from refdem.mechanics.multiple_angle import (
    cosine_by_powers,
    cosine_by_recurrence,
    cosine_product,
    cosines_mixed,
)

ANGLES = [-2.0, 0.3, 1.5, math.pi]


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("form", [cosine_by_powers, cosine_by_recurrence])
def test_three_and_four_times_an_angle_are_the_identities_of_the_chapter(form, angle):
    c = math.cos(angle)
    assert form(angle, 0) == 1
    assert form(angle, 1) == pytest.approx(c, rel=1e-15)
    assert form(angle, 3) == pytest.approx(4 * c**3 - 3 * c, abs=1e-14)
    assert form(angle, 4) == pytest.approx(8 * c**4 - 8 * c**2 + 1, abs=1e-14)


@pytest.mark.parametrize("multiple", [2, 7, 32])
def test_both_forms_are_the_cosine_of_the_multiple(multiple):
    for angle in ANGLES:
        expected = math.cos(multiple * angle)
        assert cosine_by_recurrence(angle, multiple) == pytest.approx(expected, abs=1e-12)
        assert cosine_by_powers(angle, multiple) == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("a", ANGLES)
@pytest.mark.parametrize("b", ANGLES)
def test_a_product_of_cosines_is_half_those_of_the_sum_and_of_the_difference(a, b):
    assert cosines_mixed(a, b) == pytest.approx(cosine_product(a, b), abs=1e-15)
    assert cosine_product(a, b) == pytest.approx((math.cos(a + b) + math.cos(a - b)) / 2, abs=1e-15)
