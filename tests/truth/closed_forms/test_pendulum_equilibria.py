"""Equilibria of the pendulum: Cartesian equations with the rod's force, cosh to first order, rest
at the top, bounds below.
"""

from fractions import Fraction
from math import cosh, sqrt

import pytest

from refdem.core.discovery import truth_of

SETS = [{}, {"position": "bottom", "delta": "-1/2", "length": "3"}, {"delta": "-2", "gravity": "1"}]


@pytest.mark.parametrize("given", SETS)
def test_place_and_velocity_meet_the_witness(apart, given):
    assert apart("pendulum-equilibria", (Fraction(0), Fraction(1, 2), Fraction(2)), **given) == {}


@pytest.mark.parametrize("delta", ["1e-9", "-1e-12"])
def test_the_top_is_left_as_cosh_to_first_order(delta):
    at = truth_of("pendulum-equilibria", delta=delta, gravity="2", length="3").at(Fraction(5))
    assert float(at["x"].mid) == pytest.approx(3 * float(delta) * cosh(5 * sqrt(2 / 3)), rel=1e-14)


def test_the_next_order_is_that_of_the_series():
    # phi'' = sin phi from rest: phi = d cosh t - d^3/6 ((cosh 3t - cosh t)/32 + 3 t sinh t/8) +
    # O(d^5)
    d = 1e-4
    t = 2.0
    at = truth_of("pendulum-equilibria", delta="1e-4", gravity="1").at(Fraction(2))
    third = ((cosh(3 * t) - cosh(t)) / 32 + 3 * t * sqrt(cosh(t) ** 2 - 1) / 8) / 6
    angle = Fraction(at["x"].mid) + Fraction(at["x"].mid) ** 3 / 6
    assert float((Fraction(d) * Fraction(cosh(t)) - angle) / Fraction(d) ** 3) == pytest.approx(
        third, rel=1e-4
    )


@pytest.mark.parametrize("position", ["top", "bottom"])
def test_exactly_in_equilibrium_it_stays(position):
    at = truth_of("pendulum-equilibria", delta="0", position=position).at(Fraction(1000))
    assert [at[name].mid for name in ("x", "y", "vx", "vy")] == [
        0,
        1 if position == "top" else -1,
        0,
        0,
    ]


def test_at_the_bottom_it_stays_as_near_as_it_was():
    truth = truth_of("pendulum-equilibria", delta="1/10", position="bottom")
    assert max(abs(truth.at(Fraction(k, 7))["x"].mid) for k in range(200)) <= Fraction(
        998334166468281524, 10**19
    )  # sin(1/10), up
    assert truth.sensitivity(Fraction(20)) < 20


def test_from_the_top_an_error_grows_as_cosh():
    found = truth_of("pendulum-equilibria", delta="0", gravity="1").sensitivity(Fraction(10))
    assert cosh(10) < found < 4 * cosh(10)
