"""Double pendulum: against Cartesian equations with both rods' forces, small modes, energy, and the
exponent at high energy.
"""

from fractions import Fraction
from math import log, sqrt

import pytest

from refdem.core.discovery import case, truth_of
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms import double_pendulum as module
from refdem.truth.exact import number, vector

SETS = [
    {},
    {
        "masses": "2,1/3",
        "lengths": "1/2,3/2",
        "gravity": "3",
        "theta0": "-1,2",
        "thetadot0": "3,-1",
    },
]
TIMES = (Fraction(1, 8), Fraction(1, 2))
sound = module.field


@pytest.mark.parametrize("given", SETS)
def test_angles_meet_the_cartesian_witness(apart, given):
    assert apart("double-pendulum", TIMES, **given) == {}


PLANTED = {
    "the upper bob does not feel the lower one's turning": lambda a, b, v, w: (
        w * w * (a - b).sin() / 2,
        0,
    ),
    "centrifugal term of the wrong sign": lambda a, b, v, w: (0, (a - b).sin() * v * v * -2),
    "masses mixed up by a hair": lambda a, b, v, w: (a.sin() * Fraction(1, 10**20), 0),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_the_witness_sees(apart, fault, monkeypatch):
    def field(p):
        def wrong(y):
            v, w, first, second = sound(p)(y)
            more = PLANTED[fault](*y)
            return v, w, first + more[0], second + more[1]

        return wrong

    monkeypatch.setattr(module, "field", field)
    start = {"thetadot0": "2,-3", "theta0": "1,1/3"}
    assert apart("double-pendulum", TIMES[:1], **start)


def test_small_swings_are_the_two_modes():
    # Equal masses and lengths: w^2 = (2 -+ sqrt 2) g/l, theta2 = +- sqrt 2 theta1.
    truth = truth_of(
        "double-pendulum", theta0="1e-12,1.41421356237309504880168872e-12", gravity="1"
    )
    at = truth.at(Fraction(2))
    with precision(200):
        slow = (arb_of(2) - arb_of(2).sqrt()).sqrt()
        for name, size in (("theta1", 1.0), ("theta2", sqrt(2))):
            assert float(at[name].mid) * 1e12 == pytest.approx(
                size * float((2 * slow).cos()), rel=1e-14
            )


@pytest.mark.parametrize("given", SETS)
def test_energy_stays(given):
    p = case("double-pendulum").at(**given).p
    truth = truth_of("double-pendulum", **given)
    seen = []
    with precision(200):
        (m1, m2), (l1, l2) = (
            [arb_of(x) for x in vector(p, name)] for name in ("masses", "lengths")
        )
        g = arb_of(number(p, "gravity"))
        for ball in (truth.at(t) for t in (Fraction(0), Fraction(1, 2))):
            a, b, v, w = (arb_of(ball[name].mid) for name in module.NAMES)
            first = (l1 * v * a.cos(), l1 * v * a.sin())
            second = (
                l2 * w * b.cos(),
                l2 * w * b.sin(),
            )
            lower = [x + y for x, y in zip(first, second, strict=True)]
            kinetic = m1 * sum(x * x for x in first) / 2 + m2 * sum(x * x for x in lower) / 2
            seen.append(kinetic - g * (m1 * l1 * a.cos() + m2 * (l1 * a.cos() + l2 * b.cos())))
        assert abs(float(seen[1] - seen[0])) < 1e-36


def test_neighbours_part_exponentially_at_high_energy_and_not_at_low():
    end = Fraction(4)
    high, low = (
        truth_of("double-pendulum", theta0=theta, gravity="1").sensitivity(end)
        for theta in ("3,3", "1/10,1/10")
    )
    assert log(high) / 4 > 0.5
    assert low < 20
