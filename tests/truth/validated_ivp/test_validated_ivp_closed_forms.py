"""Motions with closed forms, and motions without: extrapolated midpoint rules at many digits."""

from fractions import Fraction

import pytest
from flint import arb

from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.free_rigid_body import FreeRigidBody
from refdem.truth.refiner import Refiner
from tests.truth.validated_ivp.fields import (
    at,
    double_pendulum,
    duffing,
    growth,
    harmonic,
    integration,
    kapitza,
    kepler,
    pendulum,
    rigid_body,
    van_der_pol,
)

SPINS = [f"{name}.{a}" for name in ("omega_body", "omega") for a in "xyz"]


@pytest.mark.parametrize("t", ["1/10", "3", "50"])
def test_a_harmonic_oscillator_is_a_cosine(t):
    with precision(256):
        x, v = at(harmonic, [1, 0], t)
        time = arb_of(Fraction(t))
        assert x.overlaps(time.cos())
        assert v.overlaps(-time.sin())
        assert x.rad() < 1e-56


def test_exponentials_of_time_and_of_the_state_agree():
    with precision(256):
        y, time, integral = at(growth, [1, 0, 0], "5/2")
        assert y.overlaps(arb("2.5").exp())
        assert time.overlaps(arb("2.5"))
        assert integral.overlaps(arb("2.5").exp() - 1)
        assert integral.rad() < 1e-55


def test_a_pendulum_on_its_separatrix_rises_as_tanh():
    with precision(256):
        theta, rate = at(pendulum, [0, 2], 2)
        assert theta.overlaps(2 * arb(2).sinh().atan())
        assert rate.overlaps(2 / arb(2).cosh())
        assert theta.rad() < 1e-56


def test_a_kepler_orbit_satisfies_keplers_equation_and_closes():
    with precision(256):
        # eccentricity 3/5 from the pericentre of a = 1: x = cos E - e, t = E - e sin E
        run = integration(kepler, ["2/5", 0, 0, 2], bits=160)
        anomaly = arb(3)
        x, y, *_ = run.at(anomaly - arb_of(Fraction(3, 5)) * anomaly.sin())
        assert x.overlaps(anomaly.cos() - arb_of(Fraction(3, 5)))
        assert y.overlaps(arb_of(Fraction(4, 5)) * anomaly.sin())
        assert y.rad() < 1e-40
        x, y, u, v = run.at(2 * arb.pi())
        assert [
            x.overlaps(arb_of(Fraction(2, 5))),
            y.contains(0),
            u.contains(0),
            v.contains(2),
        ] == [True] * 4


def test_a_free_rigid_body_is_that_of_the_theta_functions():
    start = [Fraction(9, 10), Fraction(11, 10), Fraction(13, 10)]
    inertia = tuple(map(Fraction, (1, 2, 3)))
    unit = tuple(map(Fraction, (1, 0, 0, 0)))
    refiner = Refiner.of({**dict.fromkeys(SPINS, 2.0), "attitude.w": 0.5})
    truth = FreeRigidBody(refiner, inertia, tuple(start), unit).refined(60).at(Fraction(2))
    with precision(256):
        y = at(rigid_body, [*start, 1, 0, 0, 0], 2, bits=220)
        for axis, spin in zip("xyz", y, strict=False):
            ball = truth[f"omega_body.{axis}"]
            assert abs(spin.mid() - arb_of(ball.mid)) <= arb_of(ball.radius) + spin.rad()
            assert spin.rad() < 1e-60


MOTIONS = {
    "double pendulum": (double_pendulum, ["1", "1/2", "0", "0"]),
    "van der Pol": (van_der_pol, ["2", "0"]),
    "Duffing": (duffing, ["1", "0", "0"]),
    "Kapitza": (kapitza, ["1/10", "0", "0"]),
}


def forces(name, y):
    """The same motions from their Lagrangians."""
    if name == "van der Pol":
        return [y[1], 2 * y[1] - 2 * y[0] * y[0] * y[1] - y[0]]
    if name == "Duffing":
        return [y[1], arb(3) / 10 * y[2].cos() - y[1] / 4 + y[0] * (1 - y[0] * y[0]), arb(1)]
    if name == "Kapitza":
        return [y[1], y[0].sin() * (1 + 2 * (8 * y[2]).cos()), arb(1)]
    a, b, u, v = y
    sine = (a - b).sin()
    cosine = (a - b).cos()
    force = -v * v * sine - 2 * a.sin(), u * u * sine - b.sin()
    determinant = 2 - cosine * cosine
    return [
        u,
        v,
        (force[0] - cosine * force[1]) / determinant,
        (2 * force[1] - cosine * force[0]) / determinant,
    ]


def extrapolated(name, start, t, columns):
    """Gragg's midpoint rule with harmonic step numbers, extrapolated in h^2 (Hairer, Norsett,
    Wanner, section II.9).
    """
    table = []
    for k in range(1, columns + 1):
        h = t / (2 * k)
        before = start
        now = [a + h * b for a, b in zip(start, forces(name, start), strict=True)]
        for _ in range(2 * k - 1):
            before, now = (
                now,
                [a + 2 * h * b for a, b in zip(before, forces(name, now), strict=True)],
            )
        row = [
            [(a + b + h * c) / 2 for a, b, c in zip(before, now, forces(name, now), strict=True)]
        ]
        for j in range(1, k):
            ratio = arb(k) ** 2 / arb(k - j) ** 2 - 1
            row.append(
                [a + (a - b) / ratio for a, b in zip(row[-1], table[-1][j - 1], strict=True)]
            )
        table.append(row)
    return table[-1][-1]


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_without_a_closed_form_agree_with_extrapolation_of_their_lagrangian_equations(name):
    field, start = MOTIONS[name]
    with precision(400):
        y = [arb_of(Fraction(v)) for v in start]
        for _ in range(10):
            y = [value.mid() for value in extrapolated(name, y, arb(1) / 10, 14)]
        for ball, value in zip(at(field, start, 1, bits=160), y, strict=True):
            assert ball.rad() < 1e-40
            assert abs(ball - value) < 1e-24
