"""Finite-time exponents: closed forms of sigma_max, finite differences of certified flows, and what
has no variational flow.
"""

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, arb_mat

from refdem.core.discovery import truth_of
from refdem.errors import NotCertifiedError
from refdem.truth.balls import precision
from tests.exponents import exponent, exponents, log_stretch, variation


@pytest.mark.parametrize(
    "rows",
    [
        [[3, 1], [0, 2]],
        [[0, 5], [0, 0]],
        [[1, 2, 3], [4, 5, 6], [7, 8, 10]],
        [[2, 0], [0, 2]],
        [[-7]],
    ],
)
def test_the_largest_stretch_is_the_largest_singular_value(rows):
    with precision(256):
        found = log_stretch(arb_mat([[arb(x) for x in row] for row in rows]), Fraction(1, 10**12))
    assert found.rad() < 1e-12
    # sharp: the enclosure is asked for to 1e-12 and its midpoint may lie anywhere in it
    assert float(found) == pytest.approx(
        math.log(np.linalg.svd(np.array(rows, float))[1][0]), abs=1e-12
    )


def test_the_bracket_holds_where_the_matrix_is_a_ball():
    with precision(128):
        wide = arb_mat([[arb(3, 1e-6), arb(1)], [arb(0, 1e-6), arb(2)]])
        found = log_stretch(wide, Fraction(1, 10**12))
        for corner in (3 - 1e-6, 3 + 1e-6):
            assert found.contains(
                arb(math.log(np.linalg.svd(np.array([[corner, 1.0], [1e-6, 2.0]]))[1][0]), 1e-12)
            )
    assert 1e-8 < float(found.rad()) < 1e-4


@pytest.mark.parametrize("n", [1, 10, 64, 500])
def test_the_logistic_map_at_eta_4_has_log_2_by_conjugacy(n):
    truth = truth_of("logistic", eta="4", x0="1/3")
    ball = exponent(truth, Fraction(n))
    with precision(2000):  # d x_n/d x_0 = 2^n sqrt(x_n (1 - x_n)/(x_0 (1 - x_0)))
        angle = (arb(1) / 3).sqrt().asin() * arb(2) ** n
        ratio = angle.sin() ** 2 * angle.cos() ** 2 * 9 / 2
        seen = (n * arb(2).log() + ratio.log() / 2) / n
        assert abs(float(seen - arb(str(ball.decimals(30)[0])))) < 1e-20
    assert ball.radius <= Fraction(1, 10**20)
    assert abs(float(ball.mid) - math.log(2)) < 6 / n


def test_on_a_fixed_point_the_exponent_is_log_2_exactly():
    ball = exponent(
        truth_of("logistic", eta="4", x0="1/4"), Fraction(64)
    )  # x = 3/4 from the first iterate on, slope -2
    assert abs(
        ball.mid - Fraction("0.69314718055994530941723212145817656807")
    ) <= ball.radius + Fraction(1, 10**38)


def test_superstable_and_stable_cycles_are_negative_and_the_equation_too():
    assert float(exponent(truth_of("logistic", eta="5/2"), Fraction(400)).mid) == pytest.approx(
        math.log(0.5), abs=0.02
    )
    assert float(exponent(truth_of("logistic", form="ode"), Fraction(300)).mid) == pytest.approx(
        -3.75, abs=0.02
    )


def test_the_stadium_is_positive_and_the_rectangle_goes_to_zero():
    stadium = [
        float(ball.mid)
        for ball in exponents(truth_of("billiards"), [Fraction(n) for n in (32, 64, 128)])
    ]
    assert all(0.6 < value < 1.2 for value in stadium)
    truth = truth_of("billiards", geometry="rectangle")
    for n in (
        10,
        1000,
        100000,
        # D is a shear along the wall: it stretches by no more than the flight and less than twice
        # of it
    ):
        ball = exponent(truth, Fraction(n))
        time, axis = truth.bounce(n)
        across = 1 / abs(float(truth.direction[axis])) * 5
        reach = float(time) * 5 / 4 * across
        assert (
            math.log(reach)
            <= float(ball.mid) * n
            <= math.log(across * math.hypot(1, float(time) * 5 / 4) * 1.2 + 1)
        )
        assert ball.radius <= Fraction(1, 10**20)
    assert float(exponent(truth, Fraction(100000)).mid) < 2e-4


@pytest.mark.parametrize("t", [1, 10, 1000])
def test_a_harmonic_oscillator_turns_its_phase_plane_and_stretches_nothing(t):
    ball = exponent(truth_of("harmonic-oscillator"), Fraction(t))
    assert abs(ball.mid) <= ball.radius + Fraction(1, 10**30)


def test_regular_bodies_have_exponents_that_fall_as_log_t_over_t():
    for case in ("free-rigid-body", "pendulum"):
        truth = truth_of(case)
        early, late = (float(exponent(truth, Fraction(t)).mid) for t in (100, 10000))
        assert 0 < late < 2.5 * math.log(10000) / 10000
        assert late < early / 10


def test_about_the_middle_axis_only_the_linear_rate_is_positive():
    j = (1.0, 2.0, 3.0)
    w = 1.0
    rate = w * math.sqrt((j[1] - j[0]) * (j[2] - j[1]) / (j[0] * j[2]))
    steady = truth_of("free-rigid-body", inertia="1,2,3", omega_body="0,1,0")
    assert float(exponent(steady, Fraction(60)).mid) == pytest.approx(rate, abs=0.05)
    tumbling = truth_of("intermediate-axis", omega_body="0,1,0", offset="1e-2")
    early, late = (float(exponent(tumbling, Fraction(t)).mid) for t in (6, 6000))
    assert early > rate / 2
    assert late < 0.004


@pytest.mark.parametrize(
    ("case", "t"), [("driven-duffing", "3"), ("double-pendulum", "1/4"), ("stick-slip", "3/2")]
)
def test_the_variational_flow_is_that_of_neighbouring_certified_flows(case, t):
    """Columns by one-sided differences at 1e-15 of a scale, from the case's own parameters where it
    has them for the start.
    """
    t = Fraction(t)
    names = {
        "driven-duffing": ("x0", "v0"),
        "double-pendulum": ("theta0", "thetadot0"),
        "stick-slip": ("x0", "v0"),
    }[case]
    truth = truth_of(case)
    with precision(256):
        found = np.array([[float(x) for x in row] for row in variation(truth, t).table()])
    ball = exponent(truth, t, digits=18)
    assert float(ball.mid * t) == pytest.approx(math.log(np.linalg.svd(found)[1][0]), abs=1e-12)
    step = Fraction(1, 10**15)
    columns = []
    start = _start(case, names)
    base = truth.at(t)
    for i in range(len(start)):
        size = Fraction(truth.scale[truth.state[i]])
        moved = [x + (step * size if i == k else 0) for k, x in enumerate(start)]
        given = _given(names, moved)
        after = truth_of(case, **given).at(t)
        columns.append(
            [
                float((after[name].mid - base[name].mid) / step / Fraction(truth.scale[name]))
                for name in truth.state
            ]
        )
    assert np.allclose(found, np.array(columns).T, rtol=1e-9, atol=1e-9 * np.abs(found).max())


def _start(case, names):
    from refdem.core import discovery

    p = discovery.case(case).at().p
    values = [p[name] for name in names]
    return [x for value in values for x in (value if isinstance(value, tuple) else (value,))]


def _given(names, moved):
    width = len(moved) // len(names)
    return {
        name: ",".join(str(x) for x in moved[i * width : (i + 1) * width])
        for i, name in enumerate(names)
    }


def test_what_has_no_variational_flow_is_not_certified():
    with pytest.raises(NotCertifiedError, match="no variational flow"):
        exponent(truth_of("coulomb-oscillator"), Fraction(1))


def test_digits_that_the_bits_do_not_give_are_not_claimed():
    with pytest.raises(NotCertifiedError, match="radius stays"):
        exponent(truth_of("driven-duffing"), Fraction(1), digits=60)
