"""Captured mass: against a numerical orbit, in elementary numbers, and with planted errors."""

from fractions import Fraction
from math import cos, sin

import pytest

from refdem.core.discovery import truth_of
from refdem.truth.closed_forms.captured_mass import CapturedMass

GIVEN = {"mass": "3", "speed": "5/2", "radius": "2"}
TIMES = (Fraction(0), Fraction(1), Fraction(8, 5), Fraction(2), Fraction(7))


@pytest.mark.parametrize("given", [{}, GIVEN])
def test_line_and_circle_meet_the_witness(apart, given):
    assert apart("captured-mass", TIMES, **given) == {}


def test_rate_and_moment_of_inertia_are_those_of_a_circle():
    found = truth_of("captured-mass", **GIVEN).scalars()
    assert {name: ball.mid for name, ball in found.items()} == {
        "omega": Fraction(5, 4),
        "inertia": Fraction(12),
    }


def test_a_radian_after_the_catch_it_has_turned_by_a_radian():
    at = truth_of("captured-mass").at(Fraction(3))
    assert float(at["x"].mid) == pytest.approx(sin(1), rel=1e-15)
    assert float(at["vy"].mid) == pytest.approx(sin(1), rel=1e-15)
    assert float(at["y"].mid) == pytest.approx(-cos(1), rel=1e-15)


def test_energy_and_angular_momentum_about_the_hook_stay():
    truth = truth_of("captured-mass", **GIVEN)
    for t in TIMES:
        x, y, vx, vy = (truth.at(t)[name].mid for name in ("x", "y", "vx", "vy"))
        assert abs(vx * vx + vy * vy - Fraction(25, 4)) < Fraction(1, 10**38)
        assert abs(x * vy - y * vx - 5) < Fraction(1, 10**38)


PLANTED = {
    "turns the other way": lambda t: vars(t).update(spin=-t.spin),
    "caught too late": lambda t: vars(t).update(caught=t.caught + Fraction(1, 10**20)),
    "caught at the start": lambda t: vars(t).update(place=t.start[:2]),
    "omega = v r": lambda t: vars(t).update(speed2=t.speed2 * 16),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_the_witness_sees(apart, fault):
    truth = truth_of("captured-mass", **GIVEN)
    PLANTED[fault](truth)
    assert apart("captured-mass", TIMES[-1:], truth, **GIVEN)


def test_an_error_of_the_start_grows_as_the_turns_that_follow():
    truth = truth_of("captured-mass")
    assert isinstance(truth, CapturedMass)
    # Errors of the place and of the velocity, each by its scale.
    assert truth.sensitivity(Fraction(1)) == pytest.approx(2, rel=1e-6)
    assert 10 < truth.sensitivity(Fraction(12)) < 100


def test_s_is_told_for_components_along_the_axes_of_space():
    """A radian after the catch, from errors of 1 in x, y, vx and vy at the start.

    At the catch they are y + 2 vy inward and x + 2 vx along the circle; a radian later the error
    along it is x + 3 vx + y + 2 vy, in the direction (cos 1, sin 1), and inward is (-sin 1, cos 1).
    So y answers by sin 1 to x, 3 sin 1 to vx, sin 1 + cos 1 to y and twice that to vy.
    """
    largest = 4 * sin(1) + 3 * (sin(1) + cos(1))
    assert truth_of("captured-mass").sensitivity(Fraction(3)) == pytest.approx(largest, rel=1e-6)
