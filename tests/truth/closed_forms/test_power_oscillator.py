"""Power-law oscillators: against quadrature of the time along the path, cosine, Jacobi's cn, and
Liouville's theorem.
"""

from fractions import Fraction

import pytest
from flint import arb

from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.power_oscillator import inverse, magnitude, truth
from refdem.truth.jacobi import Jacobi

F = Fraction
SCALE = {"x": 1.0, "v": 1.0}

QUADRATURE = [
    (
        "1/2",
        "1.136200915563024645329419461823374043464",
        "-0.4447421001288198940921808579400381803691",
    ),
    (
        "7/2",
        "-1.205183269032764167815255482395968103914",
        "-0.285094566419281044932847755830895106779",
    ),
    (
        "21/2",
        "-0.874063497846339376223032323840656338739",
        "-0.7421289191380855392186557482231162373966",
    ),
]
"""t, x, v for m = 3, k = 2, n = 3/2, A = 5/4: roots of the time along the path by tanh-sinh
quadrature (mpmath 1.3, 45 digits).
"""


def motion(exponent, amplitude="5/4", mass="3", stiffness="2"):
    return truth(
        {
            "mass": F(mass),
            "stiffness": F(stiffness),
            "exponent": F(exponent),
            "amplitude": F(amplitude),
        },
        SCALE,
    )


@pytest.mark.parametrize(("t", "x", "v"), QUADRATURE)
def test_motion_is_that_of_quadrature_along_the_path(t, x, v):
    found = motion("3/2").at(F(t))
    for name, value in (("x", x), ("v", v)):
        assert found[name].radius <= F(1, 10**40)
        assert abs(found[name].mid - F(value)) < F(1, 10**36)


def test_period_is_that_of_quadrature():
    assert (
        motion("3/2")
        .scalars()["period"]
        .decimals(40)[0]
        .startswith("7.62314178160202132091691478227710044387")
    )


@pytest.mark.parametrize("t", ["0", "1/3", "2", "19", "-7"])
def test_one_power_is_a_cosine(t):
    found = motion(1).at(F(t))
    with precision(256):
        rate = arb_of(F(2, 3)).sqrt()
        assert abs(arb_of(found["x"].mid) - arb_of(F(5, 4)) * (rate * arb_of(F(t))).cos()) < 1e-40
        assert (
            abs(arb_of(found["v"].mid) + arb_of(F(5, 4)) * rate * (rate * arb_of(F(t))).sin())
            < 1e-40
        )


@pytest.mark.parametrize("t", ["1/3", "2", "19", "-7"])
def test_the_cube_is_jacobis_lemniscatic_cosine(t):
    found = motion(3).at(F(t))
    with precision(256):
        rate = arb_of(F(2, 3)).sqrt() * arb_of(F(5, 4))
        sn, cn, dn = Jacobi(arb(0.5), arb(0.5)).sn_cn_dn(rate * arb_of(F(t)))
        assert abs(arb_of(found["x"].mid) - arb_of(F(5, 4)) * cn) < 1e-39
        assert abs(arb_of(found["v"].mid) + arb_of(F(5, 4)) * rate * sn * dn) < 1e-39


@pytest.mark.parametrize("exponent", ["1", "3/2", "2", "13/5", "9"])
@pytest.mark.parametrize("t", ["1/8", "11/4", "5", "29"])
def test_energy_is_kept(exponent, t):
    found = motion(exponent).at(F(t))
    p = F(exponent) + 1
    with precision(256):
        power = abs(arb_of(found["x"].mid)) ** arb_of(p)
        energy = F(3, 2) * found["v"].mid ** 2
        assert (
            abs(arb_of(energy) + arb(2) / arb_of(p) * (power - arb_of(F(5, 4)) ** arb_of(p)))
            < 1e-38
        )


@pytest.mark.parametrize("exponent", ["3/2", "2", "9"])
@pytest.mark.parametrize("t", ["1/4", "3", "17"])
def test_velocity_is_the_rate_of_the_place_and_the_force_that_of_the_velocity(exponent, t):
    small = F(1, 10**12)
    flow = motion(exponent)
    before, now, after = (flow.at(F(t) + s) for s in (-small, F(0), small))
    x = float(now["x"].mid)
    assert float((after["x"].mid - before["x"].mid) / (2 * small)) == pytest.approx(
        float(now["v"].mid), rel=1e-10
    )
    pull = -2 / 3 * abs(x) ** float(F(exponent)) * (1 if x > 0 else -1)
    assert float((after["v"].mid - before["v"].mid) / (2 * small)) == pytest.approx(pull, rel=1e-9)


def test_period_of_the_square_is_that_of_the_linear_one_at_amplitude_1_195254():
    periods = [
        motion(2, amplitude, 1, 1).scalars()["period"].mid
        for amplitude in ("1.1952535", "1.1952545")
    ]
    two_pi = F("6.283185307179586476925286766559")
    assert periods[0] > two_pi > periods[1]


@pytest.mark.parametrize("exponent", ["1", "3/2", "2", "3", "9"])
@pytest.mark.parametrize("t", ["1/4", "3", "17"])
def test_the_flow_keeps_area_whatever_made_its_columns(exponent, t):
    with precision(384):
        a, b, c, d = motion(exponent).jacobian(F(t)).entries()
        assert abs(a * d - b * c - 1) < 1e-30


def test_zero_crossings_and_turning_points_are_enclosed_at_low_precision():
    flow = motion("3/2")
    quarter = flow.scalars()["period"].mid / 4
    with precision(40):
        crossing = flow.evaluate(arb_of(quarter))["x"]
        assert crossing.contains(0)
        assert crossing.rad() < 1e-8
        assert flow.evaluate(arb(0))["v"].contains(0)
    assert abs(flow.at(quarter)["x"].mid) < F(1, 10**38)


def test_powers_of_a_ball_that_holds_zero_reach_from_zero_to_its_far_end():
    with precision(128):
        for ball in (arb(0.25, 0.5), arb(-0.25, 0.5)):
            power = magnitude(ball, arb(1.5))
            assert power.contains(0)
            assert power.contains(arb(0.7499) ** arb(1.5))
            assert power < arb(0.7502) ** arb(1.5)
        assert magnitude(arb(0), arb(1.5)) == 0


@pytest.mark.parametrize("radius", [0, 1e-3, 0.1])
def test_an_inverse_holds_the_arguments_of_all_values_of_a_fat_ball(radius):
    with precision(128):
        flow = motion("3/2")
        for value in (arb(0.4, radius), arb(0, radius)):
            y = inverse(
                flow.from_centre, value, arb(1), lambda y: (1 - magnitude(y, flow.p)).rsqrt()
            )
            w = inverse(
                flow.from_turning,
                value,
                2 / flow.p,
                lambda w: 2 / flow.p * (1 - w * w) ** (1 / flow.p - 1),
            )
            for end in (-0.999, 0.999):
                inside = (value.mid() + end * arb(radius)).mid()
                exact = inverse(
                    flow.from_centre, inside, arb(1), lambda y: (1 - magnitude(y, flow.p)).rsqrt()
                )
                assert y.contains(exact)
                exact = inverse(
                    flow.from_turning,
                    inside,
                    2 / flow.p,
                    lambda w: 2 / flow.p * (1 - w * w) ** (1 / flow.p - 1),
                )
                assert w.contains(exact)


@pytest.mark.parametrize("t", ["1/4", "2", "17"])
def test_few_bits_give_fat_balls_that_hold_what_many_bits_give(t):
    with precision(300):
        sharp = motion("13/5").evaluate(arb_of(F(t)))
    with precision(30):
        fat = motion("13/5").evaluate(arb_of(F(t)))
    assert all(fat[name].contains(sharp[name]) for name in ("x", "v"))
    assert all(fat[name].rad() > 1e-9 for name in ("x", "v"))


@pytest.mark.parametrize("s", [0.3, -0.9, 1.1])
def test_places_at_a_fat_time_hold_the_places_at_all_its_times(s):
    with precision(128):
        flow = motion("3/2")
        whole = flow.place(arb(s, 1e-3))
        for by in (-0.999e-3, 0.999e-3):
            assert all(
                fat.contains(sharp)
                for fat, sharp in zip(whole, flow.place(arb(s + by)), strict=True)
            )
