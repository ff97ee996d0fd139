"""A Truth by validated integration: radii as asked for, S from the variational equation against closed forms and displaced starts."""

from copy import copy
from fractions import Fraction
from time import process_time

import pytest
from fields import harmonic, pendulum, van_der_pol
from flint import arb

from refdem.core.discovery import truth_of
from refdem.truth.balls import arb_of, precision
from refdem.truth.validated_flow import ValidatedFlow


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


def test_growth_of_errors_made_on_the_way_is_that_of_the_elliptic_functions():
    closed = truth_of("pendulum", theta0="3", thetadot0="0", gravity="1", length="1")
    scale = {"x": float(closed.scale["theta"]), "v": float(closed.scale["thetadot"])}
    only = copy(closed)
    only.scale = closed.scale | dict.fromkeys(("x", "y", "rod_force"), Fraction(10**9))
    truth = flow(pendulum, [Fraction(3), Fraction(0)], lambda y: {"x": y[0], "v": y[1]}, scale)
    times = [Fraction(k, 2) for k in range(24)]
    found = truth.sensitivities(times)
    assert found == pytest.approx(only.sensitivities(times), rel=1e-7)
    assert max(grown / truth.sensitivity(t) for grown, t in zip(found, times, strict=True)) > 1.5


def test_growth_of_a_damped_motion_needs_no_inverse_of_what_has_died_out():
    truth = flow(
        lambda y: [y[1], -y[0] * 26 - y[1] * 10], [Fraction(1), Fraction(0)], lambda y: {"x": y[0], "v": y[1]}, {"x": 1.0, "v": 5.0}
    )
    times = [Fraction(k) for k in range(0, 41, 4)]
    # exp(-5 t) (cos t + ...): every error dies out, those of the sample before are the largest
    assert truth.sensitivities(times)[1:] == pytest.approx([1.0] * 10, abs=1e-6)


def test_bits_are_those_that_the_digits_need_and_are_kept():
    truth = flow(lambda y: [y[1], y[0]], [Fraction(1), Fraction(0)], lambda y: {"x": y[0], "v": y[1]}, {"x": 1.0, "v": 1.0}, digits=30)
    assert truth.at(Fraction(1))["x"].radius <= Fraction(1, 10**30)
    assert [key[1] for key in truth.kept if key[0] == "integration"] == [128]
    with precision(400):
        assert abs(arb_of(truth.at(Fraction(40))["x"].mid) - arb(40).cosh()) < 1e-30
    kept = [key[1] for key in truth.kept if key[0] == "integration"]
    assert len(kept) == 2
    assert kept[1] < 300
    assert truth.at(Fraction(39))["x"].radius <= Fraction(1, 10**30)
    assert [key[1] for key in truth.kept if key[0] == "integration"] == kept


def test_a_forecast_is_the_cost_to_a_factor_and_nothing_once_the_pieces_exist():
    truth = flow(van_der_pol, [Fraction(2), Fraction(0)], lambda y: {"x": y[0], "v": y[1]}, {"x": 1.0, "v": 1.0})
    told = truth.forecast(Fraction(12), 40)
    begun = process_time()
    truth.at(Fraction(12))
    spent = process_time() - begun
    assert spent / 20 < told < spent * 20
    assert truth.forecast(Fraction(12), 40) == 0
    assert truth.forecast(Fraction(1200), 40) > 5 * told
    assert truth.forecast(Fraction(12), 400) > 2 * told


def test_a_state_costs_little_once_its_piece_exists():
    truth = flow(harmonic, [Fraction(1), Fraction(0)], named, {"x": 1.0, "v": 1.0, "energy": 0.1})
    truth.at(Fraction(20))
    begun = process_time()
    for k in range(200):
        truth.at(Fraction(k, 10))
    assert (process_time() - begun) / 200 < 2e-3
