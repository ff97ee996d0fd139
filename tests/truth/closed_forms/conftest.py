"""Comparison of a truth with its witness of refdem/truth/witnesses."""

from fractions import Fraction

import pytest

from refdem.core.discovery import case, truth_of
from refdem.truth.balls import arb_of, precision
from refdem.truth.witnesses.cross_check import AGREED, BITS, witnesses


@pytest.fixture
def apart():
    """`apart(name, times, truth=None, **given)`: every quantity in which the truth and its witness
    differ, with the first such time.
    """

    def found(name, times, truth=None, **given):
        truth = truth or truth_of(name, **given)
        differing = {}
        with precision(BITS):
            for t, values in witnesses()[name].values(
                case(name).at(**given).p, [Fraction(t) for t in times], {}
            ):
                if t is None:
                    balls = truth.scalars()
                else:
                    balls = truth.at(t)
                for quantity, value in values.items():
                    ball = balls[quantity]
                    close = arb_of(Fraction(1, 10**AGREED))
                    off = abs(value - arb_of(ball.mid)) - arb_of(ball.radius)
                    if not off < close * max(1.0, abs(float(ball.mid))):
                        differing.setdefault(quantity, t)
        return differing

    return found
