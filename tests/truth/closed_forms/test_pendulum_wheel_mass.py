"""Pendulum, wheel and mass: against Cartesian equations with the string's tension, energy, the
second integral and its drift.
"""

from fractions import Fraction

import pytest

from refdem.core.discovery import case, truth_of
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms import pendulum_wheel_mass as module
from refdem.truth.exact import numbers

POINT = {"wheel_radius": "0", "wheel_inertia": "0", "counter_mass": "3"}
SETS = [
    {},
    POINT,
    {
        "wheel_radius": "1/3",
        "wheel_inertia": "1/5",
        "mass": "2",
        "counter_mass": "7/3",
        "theta0": "-1",
        "rdot0": "1/2",
        "thetadot0": "2",
    },
]
TIMES = (Fraction(1, 3), Fraction(1))


@pytest.mark.parametrize("given", SETS)
def test_angles_meet_the_cartesian_witness(apart, given):
    assert apart("pendulum-wheel-mass", TIMES, **given) == {}


def rates(change):
    """The field with one of its parts changed: change(r, theta, rdot, rate, p) gives what is added
    to r'' and theta''.
    """

    def field(p):
        sound = module_field(p)

        def wrong(y):
            rdot, rate, pull, turning = sound(y)
            more = change(*y, p)
            return rdot, rate, pull + more[0], turning + more[1]

        return wrong

    return field


module_field = module.field
PLANTED = {
    "no centrifugal term": lambda r, th, v, w, p: (
        -r * w * w * p["mass"] / (p["mass"] + p["counter_mass"] + p["wheel_inertia"] * 64),
        0,
    ),
    "no Coriolis term": lambda r, th, v, w, p: (0, v * w * 2 / r),
    "half the Coriolis term": lambda r, th, v, w, p: (0, v * w / r),
    "the wheel's radius does not turn": lambda r, th, v, w, p: (
        0,
        w * w * p["wheel_radius"] / r * -1,
    ),
    "gravity of the pendulum twice": lambda r, th, v, w, p: (0, th.sin() * p["gravity"] / r * -1),
    "a hair more of the counter mass": lambda r, th, v, w, p: (Fraction(-1, 10**20), 0),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_the_witness_sees(apart, fault, monkeypatch):
    monkeypatch.setattr(module, "field", rates(PLANTED[fault]))
    assert apart("pendulum-wheel-mass", TIMES[:1])


def energy(p, ball):
    """Kinetic energy of pendulum, mass and wheel, and potential energy; the mass hangs where the
    string leaves it.
    """
    m, counter, radius, g = (
        arb_of(p[name]) for name in ("mass", "counter_mass", "wheel_radius", "gravity")
    )
    if p["wheel_radius"]:
        drag = arb_of(p["wheel_inertia"] / p["wheel_radius"] ** 2)
    else:
        drag = 0
    r, theta, rdot, rate = (arb_of(ball[name].mid) for name in module.NAMES)
    u = rdot - radius * rate
    kinetic = (m * (u * u + r * r * rate * rate) + (counter + drag) * u * u) / 2
    return (
        kinetic
        + m * g * (radius * theta.sin() - r * theta.cos())
        + counter * g * (r - radius * theta)
    )


def integral(p, ball):
    """Tufillaro's second integral of the machine with M = 3 m and a wheel of no size."""
    r, theta, rdot, rate = (arb_of(ball[name].mid) for name in module.NAMES)
    sine, cosine = (theta / 2).sin_cos()
    return (
        r * r * rate * (rdot * cosine - r * rate / 2 * sine)
        + arb_of(p["gravity"]) * r * r * sine * cosine * cosine
    )


def change(of, t, **given):
    """By how much a function of the state changes from 0 to t."""
    names = ("mass", "counter_mass", "wheel_radius", "wheel_inertia", "gravity")
    p = numbers(case("pendulum-wheel-mass").at(**given).p, *names)
    truth = truth_of("pendulum-wheel-mass", **given)
    with precision(200):
        return float(of(p, truth.at(Fraction(t))) - of(p, truth.at(Fraction(0))))


@pytest.mark.parametrize("given", SETS)
def test_energy_stays(given):
    assert abs(change(energy, "1/2", **given)) < 1e-36


def test_the_second_integral_stays_for_a_wheel_of_no_size_and_three_masses_only():
    assert abs(change(integral, 1, **POINT)) < 1e-36
    assert abs(change(integral, 1, **{**POINT, "counter_mass": "3.001"})) > 1e-4


def test_the_second_integral_drifts_in_proportion_to_the_radius():
    coarse, fine = (
        change(integral, "1/2", **{**POINT, "wheel_radius": f"1/{size}"}) * size
        for size in (1000, 4000)
    )
    assert abs(fine) > 0.1
    assert coarse == pytest.approx(fine, rel=0.01)


def test_a_pendulum_that_is_drawn_onto_the_wheel_is_refused_with_what_is_left_of_its_string():
    drawn = truth_of("pendulum-wheel-mass", rdot0="-5").refined(10)
    with pytest.raises(NotCertifiedError, match=r"on the wheel.*earlier time") as caught:
        drawn.at(Fraction(1))
    last = caught.value.state
    assert 0 < last["r"].mid < Fraction(1, 4)
    assert last["rdot"].mid < 0


def test_a_string_that_becomes_longer_is_not_said_to_bring_the_pendulum_to_the_wheel():
    with precision(64):
        near, far, away = (
            [arb_of(Fraction(r)), arb_of(0), arb_of(speed), arb_of(0)]
            for r, speed in (("1/10", -1), ("3", -1), ("1/10", 1))
        )
    assert "0.1 m" in module.drawn_onto_wheel(near, 1.0)
    assert module.drawn_onto_wheel(far, 1.0) == ""
    assert module.drawn_onto_wheel(away, 1.0) == ""
