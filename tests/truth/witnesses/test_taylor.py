"""The witnesses' Taylor integration: against functions that are known, and far from what it would
say with a wrong equation.
"""

from fractions import Fraction

import pytest
from flint import arb

from refdem.truth.balls import precision
from refdem.truth.witnesses.taylor import Solution


@pytest.fixture(autouse=True)
def digits():
    with precision(256):
        yield


def near(value: arb, expected: arb) -> bool:
    return bool(abs(value - expected) < arb(10) ** -50)


def test_the_exponential_function_over_ten_times() -> None:
    found = Solution(lambda t, y: [y[0]], [arb(1)])
    assert all(near(found.at(Fraction(t))[0] / arb(t).exp(), arb(1)) for t in (0, 1, 3, 10))


def test_an_equation_with_the_time_in_it() -> None:
    """y' = 2 t y, y = exp(t^2); and from a later begin."""
    assert near(Solution(lambda t, y: [2 * t * y[0]], [arb(1)]).at(Fraction(2))[0], arb(4).exp())
    late = Solution(lambda t, y: [2 * t * y[0]], [arb(1).exp()], begin=arb(1))
    assert near(late.at(Fraction(2))[0], arb(4).exp())


def test_roots_sines_and_quotients() -> None:
    """y' = cos(t)/(2 y) has y = sqrt(2 + sin t), from sqrt 2 at 0 on."""
    found = Solution(lambda t, y: [t.cos() / (2 * y[0])], [arb(2).sqrt()])
    assert near(found.at(Fraction(7))[0], (2 + arb(7).sin()).sqrt())


def test_a_series_with_gaps_takes_no_leap() -> None:
    """x'' = -2 x^3 from x = 0, v = 1: only every fourth coefficient differs from 0; back after the
    lemniscate constant.
    """
    found = Solution(lambda t, y: [y[1], -2 * y[0] * y[0] * y[0]], [arb(0), arb(1)])
    quarter = arb("5.24411510858423962092967917978223882736550990286324632")
    assert near(found.at(quarter)[0], arb(0))


def test_a_crossing_is_found_to_all_digits() -> None:
    found = Solution(lambda t, y: [y[1], -y[0]], [arb(0), arb(1)])
    assert near(found.crossing(lambda y: y[0], 3.1, 0.1), arb.pi())
