"""Lorenz' equations: certified states against a Runge-Kutta method in 60 digits, Liouville's
determinant, equilibria and their border of stability from the field itself.
"""

from fractions import Fraction
from itertools import pairwise

import pytest
from flint import acb_poly, arb, arb_mat

from refdem.core import discovery
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms import lorenz

CASE = discovery.case("lorenz")
NUMBERS = (Fraction(10), Fraction(28), Fraction(8, 3))
HOPF = Fraction(470, 19)
"""24.7368...: sigma (sigma + beta + 3)/(sigma - beta - 1) at Lorenz' numbers."""


def rates(state, sigma, rho, beta):
    """x', y' and z', written once more."""
    x, y, z = state
    return [sigma * (y - x), rho * x - y - x * z, x * y - beta * z]


def stepped(state, h, count, numbers):
    """The state after `count` steps h of Runge and Kutta's method, midpoints alone."""

    def moved(by, k):
        return [value + by * rate for value, rate in zip(state, k, strict=True)]

    for _ in range(count):
        k1 = rates(state, *numbers)
        k2 = rates(moved(h / 2, k1), *numbers)
        k3 = rates(moved(h / 2, k2), *numbers)
        k4 = rates(moved(h, k3), *numbers)
        slopes = zip(k1, k2, k3, k4, strict=True)
        mean = [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in slopes]
        state = [value.mid() for value in moved(h, mean)]
    return state


def extrapolated(start, t, numbers):
    """The state at t from steps t/128, t/256, ..., by Neville's scheme: the error of Runge and
    Kutta's method is a series in h^4, h^5, h^6, ...
    """
    with precision(256):
        balls = [arb_of(number) for number in numbers]
        column = [
            stepped([arb_of(x) for x in start], arb_of(t) / count, count, balls)
            for count in (128 << k for k in range(6))
        ]
        for order in range(4, 9):
            column = [
                [(2**order * f - c) / (2**order - 1) for c, f in zip(coarse, fine, strict=True)]
                for coarse, fine in pairwise(column)
            ]
    return column[-1]


def jacobian_at(state, sigma, rho, beta):
    """The derivative of the rates by the state."""
    x, y, z = state
    return arb_mat([[-sigma, sigma, arb(0)], [rho - z, arb(-1), -x], [y, x, -beta]])


@pytest.mark.parametrize("given", [{}, {"rho": "14"}, {"sigma": "7/2", "beta": "1"}])
def test_certified_states_are_those_of_extrapolated_runge_kutta_steps(given):
    instance = CASE.at(**given)
    numbers = [instance.p[name] for name in ("sigma", "rho", "beta")]
    t = Fraction(2)
    expected = extrapolated(instance.p["start"], t * instance.p["interval"], numbers)
    with precision(256):
        for ball, value in zip(instance.truth().at(t).values(), expected, strict=True):
            assert abs(float(arb_of(ball.mid) - value)) < 1e-21


@pytest.mark.parametrize("given", [{}, {"interval": "1/2"}, {"sigma": "16", "beta": "4"}])
def test_volumes_shrink_as_the_contraction_rate_says(given):
    instance = CASE.at(**given)
    truth = instance.truth()
    with precision(256):
        volume = truth.jacobian(Fraction(1)).det()
        rate = arb_of(truth.scalars()["contraction_rate"].mid)
        expected = (rate * arb_of(instance.p["interval"])).exp()
        assert abs(float(volume / expected - 1)) < 1e-6
        assert float(volume.rad() / expected) < 1e-3


def test_the_rates_vanish_at_the_equilibria():
    scalars = lorenz.constants(*NUMBERS)
    numbers = [arb_of(number) for number in NUMBERS]
    for side in (1, -1):
        across = side * scalars["equilibrium_xy"]
        place = [across, across, scalars["equilibrium_z"]]
        for rate in rates(place, *numbers):
            assert rate.contains(0)
            assert rate.rad() < 1e-10


def test_at_the_border_two_roots_are_on_the_imaginary_axis():
    """Below it all roots are on the left, beyond it two are on the right."""
    assert lorenz.hopf_rho(NUMBERS[0], NUMBERS[2]) == HOPF
    largest = {}
    for rho in (HOPF - Fraction(1, 100), HOPF, HOPF + Fraction(1, 100)):
        scalars = lorenz.constants(NUMBERS[0], rho, NUMBERS[2])
        place = [scalars["equilibrium_xy"]] * 2 + [scalars["equilibrium_z"]]
        slope = jacobian_at(place, *(arb_of(number) for number in (NUMBERS[0], rho, NUMBERS[2])))
        roots = acb_poly(slope.charpoly().coeffs()).roots(tol=2**-40)
        largest[rho] = max(float(root.real) for root in roots)
    below, at, beyond = largest.values()
    assert below < -1e-4
    assert abs(at) < 1e-11
    assert beyond > 1e-4


@pytest.mark.parametrize(
    ("sigma", "rho", "beta", "missing"),
    [
        ("10", "1", "8/3", {"equilibrium_xy", "equilibrium_z"}),
        ("2", "28", "8/3", {"hopf_rho"}),
        ("11/3", "28", "8/3", {"hopf_rho"}),
    ],
)
def test_what_does_not_exist_is_no_scalar(sigma, rho, beta, missing):
    scalars = CASE.at(sigma=sigma, rho=rho, beta=beta).truth().scalars()
    everything = {"contraction_rate", "equilibrium_xy", "equilibrium_z", "hopf_rho"}
    assert set(scalars) == everything - missing
