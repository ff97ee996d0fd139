"""Balls as exact fractions, also of numbers that no fraction can be written of."""

from fractions import Fraction

import pytest
from flint import arb

from refdem.core import discovery
from refdem.core.selection import Selection
from refdem.errors import RefdemError
from refdem.truth.balls import FARTHEST, ball_of, precision
from refdem.truth.forecast import told_to

CASES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]
TINY = Fraction(1, 2**FARTHEST)


def test_a_ball_is_told_as_it_is():
    with precision(64):
        value = arb(1) / 3 + arb(0, 1e-9)
    ball = ball_of(value)
    with precision(256):
        assert value.contains(arb(1) / 3)
    assert abs(ball.mid - Fraction(1, 3)) <= ball.radius < Fraction(2, 10**9)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_number_below_all_that_is_told_is_held_by_a_small_ball_about_0(sign):
    # log2(exp(-1e6)) = -1.4e6.
    ball = ball_of(sign * arb(-(10**6)).exp())
    assert ball.mid == 0
    assert TINY <= ball.radius <= 2 * TINY
    assert ball.decimals(45) == ("0." + 45 * "0", "1.84e-2466")


def test_a_radius_below_all_that_is_told_grows_to_what_is():
    one = ball_of(arb(1, arb(-(10**6)).exp()))
    assert (one.mid, one.radius) == (1, TINY)
    assert ball_of(arb(1)).radius == 0


def test_a_number_above_all_that_is_told_is_refused():
    assert ball_of(arb(2) ** (FARTHEST - 1)).mid == 2 ** (FARTHEST - 1)
    for value in (arb(10**6).exp(), arb(1, arb(10**6).exp())):
        with pytest.raises(ValueError, match="too large to be told"):
            ball_of(value)


@pytest.mark.parametrize("places", [40, 1005])
def test_whatever_is_told_has_decimals(places):
    for size in (FARTHEST - 1, 1 - FARTHEST):
        with precision(4096):
            mid = arb(2) ** size / 3
        mantissa, radius = ball_of(mid).decimals(places)
        assert len(mantissa) <= 4300
        assert radius


class IntegratedError(Exception):
    """The value is integrated: no time so late is waited for."""


def heard(seconds):
    raise IntegratedError


@pytest.mark.parametrize("t", ["1e5", "1e20"])
@pytest.mark.parametrize("name", CASES)
def test_of_any_case_a_late_value_has_decimals_or_a_refusal(name, t):
    instance = discovery.case(name).at()
    truth = instance.truth()
    try:
        with told_to(heard):
            truth.forecast(Fraction(t), 40)
        found = truth.at(Fraction(t))
    except (RefdemError, IntegratedError):
        return
    for ball in found.values():
        assert all(ball.decimals(45))
