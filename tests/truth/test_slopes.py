"""Derivatives beside balls, against differences of the same formulas; the supremum over cells,
against what it bounds.
"""

from fractions import Fraction

import pytest
from flint import arb

from refdem.truth.balls import arb_of, precision
from refdem.truth.growth import UnsharpError
from refdem.truth.slopes import parameters
from refdem.truth.swept_growth import Span, largest_growth

STEP = Fraction(1, 2**60)
FORMULAS = {
    "sum": lambda x, y: x + y - 3 * x + 2 - y * 5,
    "product": lambda x, y: x * y * x + 2 * y,
    "quotient": lambda x, y: (x + 1) / y + 1 / x + y / 3,
    "power": lambda x, y: x**3 * y**4,
    "root": lambda x, y: (x * x + y * y).sqrt(),
    "angle": lambda x, y: (x / y).asinh(),
    "negative": lambda x, y: -x * y - (4 - x),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_slopes_are_those_of_differences(name):
    formula = FORMULAS[name]
    place = [Fraction(5, 7), Fraction(-3, 2)]
    with precision(256):
        found = formula(*parameters([arb_of(x) for x in place]))
        assert found.value.overlaps(formula(*(arb_of(x) for x in place)))
        for i in (0, 1):
            ahead, behind = (
                formula(*(arb_of(x + sense * STEP * (i == j)) for j, x in enumerate(place)))
                for sense in (1, -1)
            )
            slope = (ahead - behind) / arb_of(2 * STEP)
            assert abs(slope - found.slopes[i]) < 1e-30


def test_powers_of_balls_that_hold_zero_are_numbers():
    (x,) = parameters([arb(0, 1e-3)])
    cube = x**3
    assert abs(cube.value) < 2e-9
    assert abs(cube.slopes[0]) < 4e-6


def bell(middle: Fraction, half: Fraction) -> tuple[list[arb], list[arb]]:
    """100/(1 + 900 (t - 1/3)^2), and something small."""

    def found(off: Fraction) -> list[arb]:
        away = arb_of(middle) + arb(0, arb_of(off).upper()) - arb(1) / 3
        return [100 / (1 + 900 * away * away), arb(1) / 2]

    return found(Fraction(0)), found(half)


def flat(middle: Fraction, half: Fraction) -> tuple[list[arb], list[arb]]:
    """A ninth."""
    return [arb(1) / 9], [arb(1) / 9]


def blurred(middle: Fraction, half: Fraction) -> tuple[list[arb], list[arb]]:
    """Something between 5 and 50."""
    return [arb(5).union(arb(50))], [arb(5).union(arb(50))]


@pytest.mark.parametrize("parts", [1, 7])
def test_the_supremum_over_cells_is_bounded_and_sharp(parts):
    spans = [Span(Fraction(k, parts), Fraction(k + 1, parts), bell) for k in range(parts)]
    assert 100 <= largest_growth(spans) <= 113


def test_what_does_not_grow_is_one():
    assert largest_growth([Span(Fraction(0), Fraction(1), flat)]) == 1.0
    assert largest_growth([]) == 1.0


def test_balls_that_never_become_narrow_are_refused():
    with pytest.raises(UnsharpError):
        largest_growth([Span(Fraction(0), Fraction(1), blurred)])
