"""The supremum over cells, against what it bounds."""

from fractions import Fraction

import pytest
from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.growth import UnsharpError
from refdem.truth.swept_growth import Span, largest_growth


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
