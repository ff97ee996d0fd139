"""Logistic map and equation: exact iterates, the conjugacy at eta = 4, period doubling, and what is
not certified.
"""

from fractions import Fraction
from itertools import pairwise

import pytest
from flint import arb, fmpq

from refdem.core.discovery import truth_of
from refdem.errors import NotCertifiedError, UsageError
from refdem.truth.balls import precision
from tests import feigenbaum
from tests.quadratic_flows import Quadratic

# mpmath with 900 digits, x -> 15/4 x (1 - x) from 1/4, 1000 times
FAR = Fraction("0.602088330620032084144587959032762099216780088")
# mpmath findroot of f^4(1/2) = 1/2 and f^8(1/2) = 1/2
SUPERSTABLE = {
    2: Fraction("3.49856169932770151999894538194453926788687904"),
    3: Fraction("3.55464086276882486536608185194849179182720001"),
}


def holds(ball, exact, digits=38):
    """The exact value lies in the ball (widened by the digits that a literal lacks), and the ball
    is small.
    """
    return abs(ball.mid - exact) <= ball.radius + Fraction(1, 10**43) and ball.radius <= Fraction(
        1, 10**digits
    )


@pytest.mark.parametrize(
    ("eta", "x0"), [("15/4", "1/4"), ("4", "1/3"), ("5/2", "7/8"), ("0", "1/2"), ("3.3", "0.3")]
)
@pytest.mark.parametrize("n", [0, 1, 2, 9])
def test_iterates_are_the_exact_rationals(paths, eta, x0, n):
    exact = paths["logistic"](eta, x0, n)
    ball = truth_of("logistic", eta=eta, x0=x0).at(Fraction(n))["x_n"]
    assert abs(ball.mid - exact) <= ball.radius <= Fraction(1, 10**40)


def test_a_thousand_iterates_keep_forty_digits():
    assert holds(truth_of("logistic", n="1000").at(Fraction(1000))["x_n"], FAR)


@pytest.mark.parametrize("x0", ["1/3", "1/4", "0.9"])
@pytest.mark.parametrize("n", [1, 7, 64, 500])
def test_at_eta_4_angles_double(x0, n):
    ball = truth_of("logistic", eta="4", x0=x0).at(Fraction(n))["x_n"]
    with precision(1500):
        start = Fraction(x0)
        angle = arb(fmpq(start.numerator, start.denominator)).sqrt().asin() * arb(2) ** n
        seen = angle.sin() ** 2
        assert seen.overlaps(
            arb(fmpq(ball.mid.numerator, ball.mid.denominator), float(ball.radius))
        )
    assert ball.radius <= Fraction(1, 10**40)


@pytest.mark.parametrize(
    ("eta", "x0", "n"), [("3/2", "1/10", 7), ("4", "1/100", 2), ("1/4", "7/8", 3)]
)
def test_the_equation_is_what_its_taylor_series_gives(eta, x0, n):
    ball = truth_of("logistic", form="ode", eta=eta, x0=x0).at(Fraction(n))["x_n"]
    with precision(256):
        rate, start = (arb(fmpq(f.numerator, f.denominator)) for f in (Fraction(eta), Fraction(x0)))
        field = Quadratic([[(rate, 0, 1), (-rate, 0, 0)], []])  # x' = eta (x 1 - x x)
        x, _ = field.flow([start, arb(1)], Fraction(n), order=120)
        assert x.overlaps(arb(fmpq(ball.mid.numerator, ball.mid.denominator), 1e-40))
        assert x.rad() < 1e-30


def test_the_equation_is_never_chaotic_and_ends_at_one():
    truth = truth_of("logistic", form="ode", eta="4", x0="1/1000")
    assert abs(float(truth.at(Fraction(60))["x_n"].mid) - 1) < 1e-15
    assert (
        truth.sensitivity(Fraction(60)) < 300
    )  # (1 - x0)^2/x0 / 4 is the most that an error can grow
    assert truth_of("logistic", form="ode", x0="0").at(Fraction(9))["x_n"].mid == 0


def test_sensitivity_at_eta_4_is_that_of_the_conjugacy():
    truth = truth_of("logistic", eta="4", x0="1/3")
    for n in (1, 10, 40):
        x = float(truth.at(Fraction(n))["x_n"].mid)
        start = 1 / 3
        assert truth.sensitivity(Fraction(n)) >= 2**n * (
            x * (1 - x) / (start * (1 - start))
        ) ** 0.5 * (1 - 1e-9)
    assert truth.sensitivity(Fraction(40)) < 2.0**45


def test_an_iterate_that_is_no_whole_number_is_refused():
    with pytest.raises(UsageError, match="whole"):
        truth_of("logistic").at(Fraction(1, 2))


def test_orbits_end_where_the_bits_are_used_up_or_where_nobody_goes():
    with pytest.raises(NotCertifiedError) as ended:
        truth_of("logistic", eta="4", x0="1/3").at(Fraction(10**6))
    assert ended.value.code == "precision"
    assert 7000 < ended.value.time < 8192
    assert ended.value.state["x_n"].radius < Fraction(1, 10**39)
    with pytest.raises(NotCertifiedError, match="not tried"):
        truth_of("logistic", eta="5/2").at(Fraction(10**6))


def test_windows_begin_where_slopes_of_cycles_pass_minus_one():
    first, second = feigenbaum.first_windows()
    assert first == 3
    eta = float(second)
    x = [(eta + 1 + s * ((eta + 1) * (eta - 3)) ** 0.5) / (2 * eta) for s in (1, -1)]
    assert abs(eta**2 * (1 - 2 * x[0]) * (1 - 2 * x[1]) + 1) < 1e-12
    for below, above, cycle in ((2.99, 3.01, 1), (3.44, 3.46, 2)):
        for value, settles in ((below, True), (above, False)):
            truth = truth_of("logistic", eta=str(value), x0="0.4")
            a, b = (float(truth.at(Fraction(n))["x_n"].mid) for n in (4000, 4000 + cycle))
            assert (abs(a - b) < 1e-3) == settles


@pytest.mark.parametrize("k", [2, 3])
def test_superstable_parameters_are_the_roots_that_others_find(k):
    found = feigenbaum.superstable(k)
    with precision(256):
        assert found.rad() < 1e-40
        assert abs(found - arb(fmpq(SUPERSTABLE[k].numerator, SUPERSTABLE[k].denominator))) < 1e-40


def test_ratios_of_certified_windows_reach_feigenbaums_number():
    found = feigenbaum.ratios(9)
    assert all(ratio.rad() < 1e-12 for ratio in found)
    assert [round(float(ratio), 5) for ratio in found[-2:]] == [4.66920, 4.66920]
    gaps = [abs(float(ratio) - 4.66920160910299) for ratio in found]
    # sharp: balls: how far the sequence has come, not how it is rounded
    assert gaps[-1] < 1e-6
    # sharp: balls: how far the sequence has come, not how it is rounded
    assert all(b < a for a, b in pairwise(gaps[2:]))


def test_the_accumulation_point_is_enclosed_from_both_sides():
    found = feigenbaum.accumulation(8)
    assert found.contains(arb("3.56994567187094490184200515138"))
    assert found.rad() < 2e-6
    for k in (4, 7):
        assert feigenbaum.superstable(k) < found < feigenbaum.tripled(5)


def test_a_zero_that_is_not_beside_the_guess_is_not_certified():
    with pytest.raises(NotCertifiedError):
        feigenbaum.only_zero(arb("3.2"), 4, arb("3.1"), arb("3.3"))
