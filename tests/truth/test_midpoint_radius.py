"""Doubles with bounds of how far they are off, against the same sums and products of rationals."""

from fractions import Fraction

import numpy as np
import pytest
from flint import arb

from refdem.truth import midpoint_radius as module
from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.midpoint_radius import MidpointRadius, exact, from_balls, together

DRAWN = 200
SHAPE = (3, 3)


def drawn(rng: np.random.Generator) -> tuple[MidpointRadius, list[list[Fraction]]]:
    """Numbers of very different sizes and signs, as doubles off by roundings and as they are."""
    sizes = 10.0 ** rng.integers(-12, 13, SHAPE)
    values = [[Fraction(x) / 3 for x in row] for row in rng.standard_normal(SHAPE) * sizes]
    with precision(96):
        return from_balls([[arb_of(x) for x in row] for row in values]), values


def product(a: list[list[Fraction]], b: list[list[Fraction]]) -> list[list[Fraction]]:
    """Of rationals."""
    inner = range(SHAPE[1])
    return [[sum(row[k] * b[k][j] for k in inner) for j in inner] for row in a]


def apart(found: MidpointRadius, true: list[list[Fraction]]) -> float:
    """The largest part of its bound by which an entry is off."""
    return max(
        float(abs(Fraction(found.midpoint[i, j]) - true[i][j]) / Fraction(found.radius[i, j]))
        for i in range(SHAPE[0])
        for j in range(SHAPE[1])
    )


def largest_part() -> float:
    """The same of products of four matrices and of sums, whose terms cancel."""
    rng = np.random.default_rng(1)
    found = 0.0
    for _ in range(DRAWN):
        first, one = drawn(rng)
        second, two = drawn(rng)
        third, three = drawn(rng)
        found = max(found, apart(first @ second @ third, product(product(one, two), three)))
        cells = range(SHAPE[1])
        whole = [[one[i][j] + two[i][j] * three[i][j] for j in cells] for i in range(SHAPE[0])]
        found = max(found, apart(first + second * third, whole))
        nothing = first + -first
        assert (nothing.midpoint == 0).all()
    return found


def test_no_sum_or_product_is_farther_off_than_its_bound():
    assert 1e-3 < largest_part() < 1


def test_so_it_is_of_products_that_vanish_below_the_smallest_doubles():
    small = MidpointRadius(np.full((1, 1), 2.0**-600), np.zeros((1, 1)))
    for product_of_both in (small * small, small @ small):
        assert Fraction(product_of_both.radius[0, 0]) >= Fraction(2) ** -1200


def test_a_bound_without_roundings_is_seen_to_be_false(monkeypatch):
    monkeypatch.setattr(module, "UNIT", 0.0)
    assert largest_part() > 1


def test_a_bound_without_what_came_in_is_seen_to_be_false(monkeypatch):
    def forgetful(self: MidpointRadius, other: MidpointRadius) -> MidpointRadius:
        return exact(self.midpoint @ other.midpoint) + exact(np.zeros(SHAPE))

    monkeypatch.setattr(MidpointRadius, "__matmul__", forgetful)
    assert largest_part() > 1


def test_a_ball_keeps_its_radius_and_what_its_double_is_off():
    with precision(192):
        third = arb(1) / 3
        wide = from_balls([third + arb(0, 1e-5), third])
    assert abs(Fraction(1, 3) - Fraction(wide.midpoint[1])) <= Fraction(wide.radius[1]) < 1e-15
    assert 1e-5 <= wide.radius[0] < 1.1e-5
    with pytest.raises(UndecidedError):
        from_balls([arb("nan")])


def test_arrays_are_put_together_with_their_bounds():
    one = MidpointRadius(np.ones(2), np.full(2, 0.5))
    both = together([one, -one])
    assert both.midpoint.tolist() == [[1.0, 1.0], [-1.0, -1.0]]
    assert both.radius.tolist() == [[0.5, 0.5], [0.5, 0.5]]
