"""Plane orbits: against Taylor series of the equations of motion, conserved vectors, and growth by
Kepler's third law.
"""

import math
from fractions import Fraction

import pytest
from flint import arb

from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.two_body_orbit import NAMES, anomaly_gain, kepler, truth

SCALE = dict.fromkeys(NAMES, 1.0)
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459")
ECCENTRICITIES = ["0", "1/2", "9/10", "99/100"]


def orbit(eccentricity="0", stiffness=None, gm="1", semi_major="1"):
    p = {
        "gm": Fraction(gm),
        "semi_major": Fraction(semi_major),
        "eccentricity": Fraction(eccentricity),
    }
    return truth({**p, "stiffness": None if stiffness is None else Fraction(stiffness)}, SCALE)


def state(orbit, t):
    balls = orbit.at(Fraction(t))
    assert all(ball.radius <= Fraction(1, 10**40) for ball in balls.values())
    return [arb_of(balls[name].mid) for name in NAMES]


def series_step(state, h, gm=1, order=48):
    """One Taylor step of r'' = -gm r/|r|^3 in Cartesian coordinates, midpoints only: recurrences
    for u = r.r, w = u^(-3/2).
    """
    x, y, vx, vy = ([part.mid()] for part in state)
    u = []
    w = []
    for n in range(order):
        u.append(sum((x[k] * x[n - k] + y[k] * y[n - k] for k in range(n + 1)), arb(0)).mid())
        if n == 0:
            w.append((1 / (u[0] * u[0].sqrt())).mid())
        else:
            total = sum(
                ((arb(-3) / 2 * k - (n - k)) * u[k] * w[n - k] for k in range(1, n + 1)), arb(0)
            )
            w.append((total / (n * u[0])).mid())
        for place, speed in ((x, vx), (y, vy)):
            pull = -gm * sum((w[k] * place[n - k] for k in range(n + 1)), arb(0))
            place.append((speed[n] / (n + 1)).mid())
            speed.append((pull / (n + 1)).mid())
    return [sum((c * h**n for n, c in enumerate(part)), arb(0)).mid() for part in (x, y, vx, vy)]


@pytest.mark.parametrize("eccentricity", ECCENTRICITIES)
def test_kepler_motion_is_the_taylor_series_of_the_equation(eccentricity):
    with precision(256):
        start = state(orbit(eccentricity), 0)
        h = Fraction(1, 8) * (1 - Fraction(eccentricity)) ** 2 / 8
        now = [part.mid() for part in start]
        for _ in range(8):
            now = series_step(now, arb_of(h))
        expected = state(orbit(eccentricity), 8 * h)
        assert max(abs(a - b) for a, b in zip(now, expected, strict=True)) < 1e-36


def test_kepler_motion_from_any_state_is_the_taylor_series_of_the_equation():
    with precision(256):
        start = [arb("0.8"), arb("-0.3"), arb("0.4"), arb("1.1")]
        now = start
        for _ in range(16):
            now = series_step(now, arb(1) / 16)
        for a, b in zip(kepler(arb(1), start, arb(1)), now, strict=True):
            assert abs(a - b) < 1e-36


@pytest.mark.parametrize("eccentricity", ECCENTRICITIES)
@pytest.mark.parametrize("t", ["0", "3", "62.8"])
def test_energy_angular_momentum_and_laplace_vector_are_those_of_the_elements(eccentricity, t):
    e = Fraction(eccentricity)
    with precision(256):
        x, y, vx, vy = state(orbit(eccentricity), t)
        r = (x * x + y * y).sqrt()
        momentum = x * vy - y * vx
        assert abs((vx * vx + vy * vy) / 2 - 1 / r + arb(1) / 2) < 1e-37
        assert abs(momentum * momentum - arb_of(1 - e * e)) < 1e-37
        assert abs(vy * momentum - x / r - arb_of(e)) < 1e-37
        assert abs(vx * momentum + y / r) < 1e-37


@pytest.mark.parametrize(
    ("given", "period"),
    [({}, 2 * PI), ({"gm": "4", "semi_major": "4"}, 8 * PI), ({"stiffness": "4"}, PI)],
)
def test_period_brings_the_start_back(given, period):
    revolving = orbit("1/2", **given)
    assert abs(revolving.scalars()["period"].mid - period) < Fraction(1, 10**40)
    with precision(256):
        for a, b in zip(state(revolving, period), state(revolving, 0), strict=True):
            assert abs(a - b) < 1e-38


def test_at_half_a_period_it_is_at_apoapsis():
    with precision(256):
        for value, expected in zip(
            state(orbit("3/5"), PI), ("-1.6", "0", "0", "-0.5"), strict=True
        ):
            assert abs(value - arb(expected)) < 1e-38


def test_spring_orbit_is_an_ellipse_about_the_centre():
    with precision(256):
        for t in ("0", "1", "100.7"):
            x, y, vx, vy = state(orbit("3/5", stiffness="4"), t)
            assert abs(x * x + y * y / arb("0.64") - 1) < 1e-37
            assert abs(x * vy - y * vx - arb("1.6")) < 1e-37
            assert abs(vx * vx + vy * vy + 4 * (x * x + y * y) - 4 * arb("1.64")) < 1e-37


def test_spring_motion_has_the_acceleration_of_the_spring():
    h = Fraction(1, 2**40)
    spring = orbit("3/5", stiffness="4").refined(60)
    before, now, after = (spring.at(Fraction(1) + by) for by in (-h, 0, h))
    for name in ("x", "y"):
        acceleration = (before[name].mid - 2 * now[name].mid + after[name].mid) / h**2
        assert abs(acceleration + 4 * now[name].mid) < Fraction(1, 10**20)


def test_the_ball_of_keplers_equation_holds_a_change_of_sign():
    with precision(200):
        for mean in ("0", "0.001", "1", "3.1415926", "1000.3"):
            c = arb("0.99")
            s = arb("0.1")
            m = arb(mean)
            ball = anomaly_gain(m, c, s)
            for end, side in ((ball.mid() - arb(1e-50), -1), (ball.mid() + arb(1e-50), 1)):
                assert side * (end - c * end.sin() + s * (1 - end.cos()) - m) > 0
            assert ball.rad() < 1e-50


def test_growth_over_one_circular_turn_is_that_of_the_third_law():
    # Energy rises by dx + dvy, the axis by twice that, the period by 6 pi (dx + dvy): the neighbour
    # is late by as much along y. One that is made elsewhere on the circle may answer in x and y
    # together, and so by up to a root of two more.
    growth = 12 * float(PI) + 1
    assert growth <= orbit("0").sensitivity(2 * PI) <= 2**0.5 * 1.2 * growth


@pytest.mark.parametrize(("gm", "semi_major"), [("1", "1"), ("0.9", "1.2"), ("7/3", "0.31")])
def test_a_circle_of_any_size_is_certified(gm, semi_major):
    """x = a cos n t, y = a sin n t with n^2 a^3 = gm, by floating point."""
    circle = orbit(gm=gm, semi_major=semi_major)
    a = float(Fraction(semi_major))
    rate = (float(Fraction(gm)) / a**3) ** 0.5
    ball = circle.at(Fraction(16, 5))
    assert float(ball["x"].mid) == pytest.approx(a * math.cos(3.2 * rate), abs=1e-13)
    assert float(ball["y"].mid) == pytest.approx(a * math.sin(3.2 * rate), abs=1e-13)
    assert 1 <= circle.sensitivity(Fraction(16, 5)) < 1e4


def test_no_certified_time_has_no_sensitivities():
    assert orbit().sensitivities([]) == []
