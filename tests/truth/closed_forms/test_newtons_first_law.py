"""Force-free motion: against the Taylor series of the attitude's equation in rationals, and known
rows of its response.
"""

from fractions import Fraction

import pytest

from refdem.errors import UsageError
from refdem.truth.closed_forms.newtons_first_law import free, resting
from tests.rationals import hamilton

OMEGA = (Fraction(1, 2), Fraction(-1), Fraction(3, 4))
ATTITUDE = (Fraction(3, 5), Fraction(0), Fraction(4, 5), Fraction(0))


def attitude_series(t):
    """q(t) of qdot = omega q/2 by its Taylor series."""
    term = ATTITUDE
    total = ATTITUDE
    for n in range(1, 80):
        term = tuple(part * t / (2 * n) for part in hamilton((0, *OMEGA), term))
        total = tuple(a + b for a, b in zip(total, term, strict=True))
    return total


@pytest.mark.parametrize("t", [Fraction(0), Fraction(7, 3), Fraction(-5)])
def test_attitude_is_the_taylor_series_of_its_equation(t):
    balls = free(
        {"x": 2.0}, position=(1, 2, 3), velocity=(0, 0, 0), omega=OMEGA, attitude=ATTITUDE
    ).at(t)
    for axis, value in zip("wxyz", attitude_series(t), strict=True):
        ball = balls[f"attitude.{axis}"]
        assert ball.radius <= Fraction(1, 10**40)
        assert abs(ball.mid - value) <= ball.radius + Fraction(1, 10**50)


def test_position_is_linear_and_velocity_and_spin_stay():
    balls = free({}, position=(1, 2, 3), velocity=("1/10", -2, 0), omega=OMEGA).at(Fraction(10))
    values = {name: ball.mid for name, ball in balls.items()}
    tiny = Fraction(1, 10**60)
    assert abs(values["x"] - 2) < tiny
    assert abs(values["vx"] - Fraction(1, 10)) < tiny
    assert (values["y"], values["z"], values["vy"], values["vz"]) == (-18, 3, -2, 0)
    assert tuple(values[f"omega.{axis}"] for axis in "xyz") == OMEGA


def test_a_body_that_does_not_spin_keeps_its_attitude():
    balls = free({}, position=(0, 0, 0), velocity=(0, 0, 0), omega=(0, 0, 0), attitude=ATTITUDE).at(
        Fraction(9)
    )
    assert abs(balls["attitude.w"].mid - Fraction(3, 5)) < Fraction(1, 10**60)


def test_an_attitude_that_is_no_rotation_is_refused():
    with pytest.raises(UsageError, match="squares"):
        free({}, position=(0, 0, 0), velocity=(0, 0, 0), omega=(0, 0, 0), attitude=(1, 1, 0, 0))


def test_sensitivity_grows_with_the_way_gone_and_the_angle_turned():
    scale = {"x": 1.0, "y": 1.0, "z": 1.0, "vx": 2.0, "vy": 2.0, "vz": 2.0}
    straight = free(scale, position=(0, 0, 0), velocity=(1, 0, 0), omega=(0, 0, 0))
    assert straight.sensitivity(Fraction(0)) == pytest.approx(1.0)
    assert straight.sensitivity(Fraction(10)) == pytest.approx(1 + 2 * 10, rel=1e-9)
    spinning = free({"omega.z": 8.0}, position=(0, 0, 0), velocity=(0, 0, 0), omega=(0, 0, 8))
    assert spinning.sensitivity(Fraction(10)) >= 1 + 10 * 8 / 2 * 0.7


def test_resting_bodies_have_zero_displacement_and_velocity_for_ever():
    still = resting(2)
    balls = still.at(Fraction(10**6))
    assert sorted(balls) == sorted(
        f"{kind}{i}.{axis}" for i in (1, 2) for kind in "rv" for axis in "xyz"
    )
    assert all((ball.mid, ball.radius) == (0, 0) for ball in balls.values())
    assert still.sensitivity(Fraction(10**6)) == 1.0
