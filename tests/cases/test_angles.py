"""Angles of many turns: their directions are those of the exact angles."""

from fractions import Fraction

import numpy as np
import pytest
from flint import arb, ctx

from refdem.core import discovery

TWO = ("double-pendulum", "coupled-pendulums")
ONE = ("pendulum", "kapitza-pendulum", "pendulum-wheel-mass")


def sine(angle):
    """The sine of an exact angle, by another library and to 200 bits."""
    bits = ctx.prec
    ctx.prec = 200
    try:
        exact = arb(angle.numerator) / angle.denominator
        return float(exact.sin())
    finally:
        ctx.prec = bits


def started(case, angle):
    """x of the first body of a case that starts at this angle [rad], and at the angle 0."""
    text = f"{angle.numerator}/{angle.denominator}"
    places = []
    for start in (text, "0"):
        value = start
        if case in TWO:
            value = f"{start},1/2"
        places.append(discovery.case(case).at(theta0=value).scene.bodies.position[0])
    return places


@pytest.mark.parametrize("case", [*ONE, *TWO])
@pytest.mark.parametrize("angle", [Fraction(14703, 10), Fraction(-(10**9) - 1, 7)])
def test_a_rod_points_where_the_exact_angle_of_many_turns_does(case, angle):
    place, straight = started(case, angle)
    # Along y at the angle 0, beside a wheel of radius R.
    across = np.hypot(*(place - straight)[:2]) / 2
    half = abs(sine(angle / 2))
    length = abs(straight[1]) or 1.0
    if case == "kapitza-pendulum":
        length = 1.0
    if case == "pendulum-wheel-mass":
        length = np.hypot(*straight[:2])
    # The chord of the angle is 2 l |sin(angle/2)|.
    assert across == pytest.approx(length * half, rel=1e-14)
