"""Balls keep their promise when they are rounded or printed."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from refdem.core.truth import Ball

fractions = st.fractions(min_value=-(10**12), max_value=10**12, max_denominator=10**30)
radii = st.fractions(min_value=0, max_value=1, max_denominator=10**40)


@given(fractions, radii, st.integers(0, 60))
def test_the_decimal_interval_contains_the_ball(mid, radius, places):
    text, slack = Ball(mid, radius).decimals(places)
    assert Fraction(text) - Fraction(slack) <= mid - radius
    assert mid + radius <= Fraction(text) + Fraction(slack)


@given(fractions, radii)
def test_the_rounded_interval_contains_the_ball(mid, radius):
    value, slack = Ball(mid, radius).rounded()
    assert Fraction(value) - Fraction(slack) <= mid - radius
    assert mid + radius <= Fraction(value) + Fraction(slack)


def test_a_double_that_is_exact_has_radius_zero():
    assert Ball(Fraction(3, 8), Fraction(0)).rounded() == (0.375, 0.0)


@pytest.mark.parametrize(
    ("mid", "places", "text"),
    [(Fraction(-1, 10), 3, "-0.100"), (Fraction(123456), 2, "123456.00"), (Fraction(0), 1, "0.0")],
)
def test_decimals_are_plain(mid, places, text):
    assert Ball(mid, Fraction(0)).decimals(places)[0] == text
