"""Harmonic oscillator: against its Taylor series in rationals, and the period in literal digits."""

from fractions import Fraction

import pytest

from refdem.truth.closed_forms.harmonic_oscillator import truth

PARAMETERS = {
    "mass": Fraction(3, 2),
    "stiffness": Fraction(7, 5),
    "gravity": Fraction(0),
    "x0": Fraction(1),
    "v0": Fraction(-2, 3),
}
SCALE = {"x": 1.0, "v": 1.0}


def series(p, t):
    """x and v by the Taylor series of m x'' = m g - k x, in exact rationals."""
    ratio = p["stiffness"] / p["mass"]
    force = p["gravity"]
    coefficients = [p["x0"], p["v0"]]
    for n in range(90):
        coefficients.append((force * (n == 0) - ratio * coefficients[n]) / ((n + 1) * (n + 2)))
    x = sum(c * t**n for n, c in enumerate(coefficients))
    return x, sum(n * c * t ** (n - 1) for n, c in enumerate(coefficients) if n)


@pytest.mark.parametrize("gravity", [Fraction(0), Fraction(981, 100)])
@pytest.mark.parametrize("t", [Fraction(0), Fraction(1, 2), Fraction(5), Fraction(-3)])
def test_motion_is_the_taylor_series_of_the_equation(gravity, t):
    p = {**PARAMETERS, "gravity": gravity}
    balls = truth(p, SCALE).at(t)
    expected = series(p, t)
    for name, value in zip(("x", "v"), expected, strict=True):
        assert balls[name].radius <= Fraction(1, 10**40)
        assert abs(balls[name].mid - value) <= balls[name].radius + Fraction(1, 10**50)


def test_gravity_shifts_the_motion_by_m_g_over_k_and_nothing_else():
    hanging = {**PARAMETERS, "gravity": Fraction(2), "x0": PARAMETERS["x0"] + Fraction(15, 7)}
    shifted = truth(hanging, SCALE).at(Fraction(4))
    plain = truth(PARAMETERS, SCALE).at(Fraction(4))
    assert abs(shifted["x"].mid - plain["x"].mid - Fraction(15, 7)) < Fraction(1, 10**60)
    assert abs(shifted["v"].mid - plain["v"].mid) < Fraction(1, 10**60)
    assert truth(hanging, SCALE).scalars() == truth(PARAMETERS, SCALE).scalars()


def test_period_of_unit_mass_and_stiffness_four_is_pi():
    period = truth({**PARAMETERS, "mass": Fraction(1), "stiffness": Fraction(4)}, SCALE).scalars()[
        "period"
    ]
    assert period.decimals(41)[0].startswith("3.141592653589793238462643383279502884197")


def test_sensitivity_in_scales_of_the_energy_is_at_most_root_two():
    unit = {**PARAMETERS, "mass": Fraction(1), "stiffness": Fraction(1)}
    assert truth(unit, SCALE).sensitivity(Fraction(0)) == pytest.approx(1.0, abs=1e-12)
    eighth = Fraction(355, 113) / 4
    assert 2**0.5 * (1 - 1e-12) <= truth(unit, SCALE).sensitivity(eighth) <= 1.2 * 2**0.5


def test_sensitivity_in_other_scales_is_the_largest_row_of_the_rotation():
    unit = {**PARAMETERS, "mass": Fraction(1), "stiffness": Fraction(1)}
    quarter = Fraction(355, 113) / 2
    assert 4.0 * (1 - 1e-5) <= truth(unit, {"x": 0.5, "v": 2.0}).sensitivity(quarter) <= 1.2 * 4.0
