"""Derivatives of the hypergeometric function hold differences of its values, and the bound of what
a series leaves out holds that.
"""

from fractions import Fraction
from random import Random

import pytest
from flint import arb

from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.dual import DualBall, parameters, slopes_of
from refdem.truth.hypergeometric import Ratio, Which, remainder, slope_by, two_f_one

STEP = Fraction(1, 10**40)
"""Differences over it have an error of 1e-80 times the third derivative."""
RANDOM = Random(41)
PLACES = [
    (
        Fraction(RANDOM.randint(-300, 300), 101),
        Fraction(RANDOM.randint(-300, 300), 103),
        Fraction(RANDOM.randint(20, 300), 107),
        Fraction(RANDOM.randint(-60, 60), 97),
    )
    for _ in range(20)
]


@pytest.mark.parametrize("place", PLACES)
def test_derivatives_by_every_argument_are_what_differences_tend_to(
    place: tuple[Fraction, ...],
) -> None:
    with precision(192):
        slopes = slopes_of(two_f_one(*parameters([arb_of(x) for x in place])))
    for k, slope in enumerate(slopes):
        with precision(1024):
            ahead, behind = (
                two_f_one(*(arb_of(x + (i == k) * sense * STEP) for i, x in enumerate(place)))
                for sense in (1, -1)
            )
            seen = (ahead - behind) / arb_of(2 * STEP)
            assert abs(slope - seen) < arb(10) ** -50, k
            assert slope.rad() < arb(10) ** -50, k


def test_the_value_is_that_without_derivatives() -> None:
    a, b, c, z = (arb_of(Fraction(k, 7)) for k in (1, 2, 3, 4))
    dual = two_f_one(DualBall(a, [arb(1)]), b, c, z)
    assert dual.value.repr() == z.hypgeom_2f1(a, b, c).repr()


@pytest.mark.parametrize("which", ["a", "b", "c"])
def test_the_remainder_bounds_all_terms_that_are_left_out(which: Which) -> None:
    with precision(256):
        left_out_is_bounded(which)


def left_out_is_bounded(which: Which) -> None:
    """Fails unless every remainder holds what is left out, and late ones are near it."""
    ratio = Ratio(*(arb_of(Fraction(k, 12)) for k in (-5, 17, 8, 7)))
    whole = slope_by(ratio, which)
    term = arb(1)
    slope = arb(0)
    total = arb(0)
    seen = 0
    for n in range(60):
        slope = ratio.slope(which, n) * term + ratio.at(n) * slope
        term = ratio.at(n) * term
        rest = remainder(ratio, which, n + 1, term, slope)
        if rest is not None:
            seen += 1
            left_out = whole - total
            assert abs(left_out) < rest.abs_upper()
            # It is no more than a few times what it bounds.
            if n > 40:
                assert rest.abs_upper() < 8 * abs(left_out)
        total += slope
    assert seen > 30


def test_a_series_that_does_not_converge_is_undecided() -> None:
    ratio = Ratio(arb(0.5), arb(0.5), arb(1.5), arb(1.5))
    with pytest.raises(UndecidedError):
        slope_by(ratio, "a")
