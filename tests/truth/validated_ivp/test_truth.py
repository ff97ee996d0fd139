"""A Truth by validated integration: radii as asked for, S from the variational equation against closed forms and displaced starts."""

from fractions import Fraction

import pytest
from fields import harmonic, pendulum
from flint import arb

from refdem.core.discovery import truth_of
from refdem.truth.balls import arb_of, precision
from refdem.truth.validated_ivp.truth import ValidatedFlow


def flow(rule, start, quantities, scale, digits=40):
    return ValidatedFlow(rule, start, quantities, scale, state=("x", "v"), moved=(0, 1), digits=digits)


def named(y):
    """Position, velocity and energy of an oscillator."""
    return {"energy": (y[0] * y[0] + y[1] * y[1]) / 2, "x": y[0], "v": y[1]}


def test_quantities_have_the_radius_asked_for_at_any_time():
    truth = flow(harmonic, [Fraction(1, 3), Fraction(0)], named, {"x": 1.0, "v": 1.0, "energy": 0.1}, digits=70)
    found = truth.at(Fraction(7, 3))
    with precision(400):
        assert abs(arb_of(found["x"].mid) - arb_of(Fraction(7, 3)).cos() / 3) <= arb_of(found["x"].radius)
    assert abs(found["energy"].mid - Fraction(1, 18)) <= found["energy"].radius
    assert all(ball.radius <= Fraction(1, 10**71) for ball in found.values())


def test_sensitivity_of_an_oscillator_is_that_of_a_rotation():
    truth = flow(harmonic, [Fraction(1), Fraction(0)], lambda y: {"x": y[0], "v": y[1]}, {"x": 1.0, "v": 4.0})
    t = arb(2)
    assert truth.sensitivity(Fraction(2)) == pytest.approx(float(abs(t.cos()) + 4 * t.sin()), rel=1e-9)


def test_a_pendulum_and_its_growth_are_those_of_the_elliptic_functions():
    closed = truth_of("pendulum", theta0="3", thetadot0="1", gravity="1", length="1")
    scale = {"x": float(closed.scale["theta"]), "v": float(closed.scale["thetadot"])}
    truth = flow(pendulum, [Fraction(3), Fraction(1)], lambda y: {"x": y[0], "v": y[1]}, scale)
    times = [Fraction(0), Fraction(5, 4), Fraction(4)]
    ball, other = truth.at(times[-1])["v"], closed.at(times[-1])["thetadot"]
    assert abs(ball.mid - other.mid) <= ball.radius + other.radius
    displaced = truth.displaced(1, Fraction(1, 10**20)).at(times[-1])["x"].mid - truth.at(times[-1])["x"].mid
    slope = float(truth.jacobian(times[-1])[0, 1].mid()) * scale["x"] / scale["v"]
    assert float(displaced) * 1e20 == pytest.approx(slope, rel=1e-9)
    assert truth.sensitivities(times)[-1] >= truth.sensitivity(times[-1])
