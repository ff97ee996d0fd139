"""Intermediate axis: start, flips and what happens next to the separatrix."""

from fractions import Fraction
from math import log, sqrt

import pytest

from refdem.core.discovery import case, truth_of
from refdem.truth.closed_forms.intermediate_axis import start

LAMBDA = sqrt(1 / 3)  # omega_2 = 1, J = (1, 2, 3)


def flip_time(**given):
    return truth_of("intermediate-axis", **given).scalars()["flip_time"]


@pytest.mark.parametrize("direction", ["1", "3"])
def test_flip_time_grows_as_the_logarithm_of_the_offset(direction):
    times = [float(flip_time(offset=f"1e-{k}", direction=direction).mid) for k in (9, 12, 30, 33)]
    for earlier, later in ((0, 1), (2, 3)):
        assert times[later] - times[earlier] == pytest.approx(2 / LAMBDA * log(1e3), rel=1e-13)


@pytest.mark.parametrize("offset", ["0.1", "1e-9", "1e-30"])
def test_omega_2_changes_sign_once_every_flip_time(offset):
    truth = truth_of("intermediate-axis", offset=offset)
    interval = flip_time(offset=offset).mid
    signs = [truth.at(round(interval * k, 6))["omega_body.y"].mid > 0 for k in range(6)]
    assert signs == [True, False] * 3


@pytest.mark.parametrize("offset", ["1e-30", "1e-60"])
def test_starts_next_to_the_separatrix_keep_their_digits(offset):
    truth = truth_of("intermediate-axis", offset=offset).refined(60)
    ball = truth.at(flip_time(offset=offset).mid.limit_denominator(1000))["attitude.w"]
    assert ball.radius <= Fraction(1, 10**60)


def test_near_the_other_axes_nothing_flips():
    for omega, name, direction in (("1,0,0", "omega_body.x", "3"), ("0,0,-1", "omega_body.z", "1")):
        truth = truth_of("intermediate-axis", omega_body=omega, direction=direction, offset="0.01")
        assert all(abs(float(truth.at(Fraction(t))[name].mid)) > 0.999 for t in range(0, 200, 7))


def test_offset_is_part_of_the_size_of_omega():
    p = case("intermediate-axis").at(omega_body="0,-3,4", offset="1/10", direction="3").p
    assert start(p) == (0, -3, Fraction(9, 2))


def test_an_irrational_size_of_omega_is_known_to_every_digit_that_is_asked_for():
    """It was taken to 1000 bits: at 400 digits every value was outside its ball."""
    truth = truth_of("intermediate-axis", omega_body="1,1,1", offset="1e-3", direction="1").refined(
        400
    )
    found = truth.at(Fraction(0))["omega_body.x"]
    # (x - 1)^2 = 3/10^6, x > 1
    low = found.mid - found.radius - 1
    high = found.mid + found.radius - 1
    assert low * low <= Fraction(3, 10**6) <= high * high
    assert found.radius < Fraction(1, 10**400)


def test_exact_start_is_the_one_that_engines_round():
    instance = case("intermediate-axis").at(omega_body="0.1,1,0.3", offset="0.01", direction="3")
    values = instance.truth().at(Fraction(0))
    omega = instance.scene.bodies.omega[0]
    assert [float(values[f"omega.{a}"].mid) for a in "xyz"] == pytest.approx(list(omega), rel=1e-15)
