"""Coupled pendulums: against Cartesian equations with the rods' forces, the two modes and their
beats, and energy.
"""

from fractions import Fraction
from math import pi, sqrt

import pytest

from refdem.core.discovery import case, truth_of
from refdem.errors import UsageError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms import coupled_pendulums as module
from refdem.truth.exact import number, vector

SETS = [
    {},
    {"spring_length": "0"},
    {
        "masses": "2,1/3",
        "lengths": "1/2,3/2",
        "distance": "2",
        "gravity": "3",
        "stiffness": "5",
        "spring_length": "1/4",
        "theta0": "-1,2",
        "thetadot0": "3,-1",
    },
]
TIMES = (Fraction(1, 8), Fraction(1, 2))
sound = module.field


@pytest.mark.parametrize("given", SETS)
def test_angles_meet_the_cartesian_witness(apart, given):
    assert apart("coupled-pendulums", TIMES, **given) == {}


PLANTED = {
    "the spring pulls the second bob alone": lambda a, b: (-(b.sin() - a.sin()) * a.cos(), 0),
    "the spring pushes both the same way": lambda a, b: (0, (b.sin() - a.sin()) * b.cos() * 2),
    "gravity by a hair too strong": lambda a, b: (a.sin() * Fraction(1, 10**20), 0),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_the_witness_sees(apart, fault, monkeypatch):
    def field(p):
        def wrong(y):
            v, w, first, second = sound(p)(y)
            more = PLANTED[fault](*y[:2])
            return v, w, first + more[0], second + more[1]

        return wrong

    monkeypatch.setattr(module, "field", field)
    assert apart("coupled-pendulums", TIMES[:1], theta0="1,1/3")


SMALL = 1e-12
"""[rad] of a swing whose cubic terms are far below a rounding."""


def small_swing(first: str, second: str, t: Fraction) -> list[float]:
    """Both angles over SMALL, of alike pendulums with g/l = 1 and k/m = 3/2, at time t."""
    truth = truth_of("coupled-pendulums", theta0=f"{first},{second}", gravity="1", stiffness="3/2")
    at = truth.at(t)
    return [float(at[name].mid) / SMALL for name in ("theta1", "theta2")]


def test_small_swings_in_step_do_not_feel_the_spring():
    # theta1 = theta2: w^2 = g/l.
    found = small_swing("1e-12", "1e-12", Fraction(2))
    with precision(100):
        expected = float(arb_of(2).cos())
    assert found == pytest.approx([expected, expected], rel=1e-12)


def test_small_swings_against_each_other_stretch_the_spring_twice():
    # theta2 = -theta1: w^2 = g/l + 2 k/m = 4.
    found = small_swing("1e-12", "-1e-12", Fraction(2))
    with precision(100):
        expected = float(arb_of(4).cos())
    assert found == pytest.approx([expected, -expected], rel=1e-11)


def test_a_swing_passes_to_the_other_pendulum_in_half_a_beat():
    # theta1 = (cos w1 t + cos w2 t)/2 and theta2 = (cos w1 t - cos w2 t)/2, w2 - w1 = 1: at t = pi
    # both waves are opposite, and the first pendulum stands still.
    t = Fraction(pi)
    first, second = small_swing("1e-12", "0", t)
    assert first == pytest.approx(0.0, abs=1e-11)
    assert second == pytest.approx(-1.0, rel=1e-11)


@pytest.mark.parametrize("given", SETS)
def test_energy_stays(given):
    p = case("coupled-pendulums").at(**given).p
    truth = truth_of("coupled-pendulums", **given)
    energies = []
    with precision(200):
        masses = [arb_of(x) for x in vector(p, "masses")]
        lengths = [arb_of(x) for x in vector(p, "lengths")]
        g, d, k, s0 = (
            arb_of(number(p, name))
            for name in ("gravity", "distance", "stiffness", "spring_length")
        )
        for ball in (truth.at(t) for t in (Fraction(0), Fraction(1, 2))):
            a, b, v, w = (arb_of(ball[name].mid) for name in module.NAMES)
            m1, m2 = masses
            l1, l2 = lengths
            kinetic = (m1 * (l1 * v) ** 2 + m2 * (l2 * w) ** 2) / 2
            height = -m1 * l1 * a.cos() - m2 * l2 * b.cos()
            spring_x = d + l2 * b.sin() - l1 * a.sin()
            spring_y = l1 * a.cos() - l2 * b.cos()
            stretch = (spring_x**2 + spring_y**2).sqrt() - s0
            energies.append(kinetic + g * height + k * stretch**2 / 2)
        assert abs(float(energies[1] - energies[0])) < 1e-36


def test_bobs_in_one_place_are_refused():
    with pytest.raises(UsageError, match="spring has no direction"):
        case("coupled-pendulums").at(theta0="1e-8,-1e-8", distance="2e-8")


def test_the_duration_shows_the_energy_pass():
    instance = case("coupled-pendulums").at()
    modes = [sqrt(9.8125), sqrt(9.8125 + 2 * 2)]
    half_beat = pi / (modes[1] - modes[0])
    assert instance.scales.duration > half_beat


def test_tau_is_that_of_a_light_bob_that_a_stretched_spring_pulls():
    """The energy is small for both bobs, and the force large for one: Runge and Kutta's method was
    seen to miss its bound at steps that were as long as tau.
    """
    given = {"masses": "1000,1/100", "distance": "100", "stiffness": "10", "theta0": "0,0"}
    tau = case("coupled-pendulums").at(**given).scales.tau
    # F/(m l) with F = k (d - s).
    assert tau == pytest.approx(sqrt(0.01 / (10 * 99.25)), rel=1e-12)
