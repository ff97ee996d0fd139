"""Proven Taylor pieces: low orders, where the remainder carries all, fat starts, first zeros, and errors planted in them."""

from fractions import Fraction

import pytest
from flint import arb, arb_poly

from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision
from refdem.truth.validated import Flow, enclosure, first_zero, is_positive, taylor


def squares(y):
    """y' = y^2: y = 1/(1/y0 - t)."""
    return [y[0] * y[0]]


def turning(y):
    """x'' = -x."""
    return [y[1], -y[0]]


@pytest.mark.parametrize("order", range(1, 9))
def test_a_low_order_piece_contains_the_exact_solution_by_its_remainder_alone(order):
    with precision(200):
        piece = Flow(squares, [arb(1)], Fraction(1, 8), order).piece(0)
        for n in range(1, 9):
            t = arb(n) / 64
            assert piece.at(t)[0].contains(1 / (1 - t))


@pytest.mark.parametrize("order", range(1, 9))
def test_without_its_remainder_the_piece_would_miss_the_solution(order):
    with precision(200):
        thin = taylor(squares, [arb(1)], order)[0]
        assert not thin(arb(1) / 8).contains(1 / (1 - arb(1) / 8))


def test_a_remainder_taken_at_the_start_instead_of_over_the_enclosure_would_miss_the_solution():
    with precision(200):
        at_start = taylor(squares, [arb(1)], 5)[0]
        assert not at_start(arb(1) / 8).overlaps(1 / (1 - arb(1) / 8))


def test_many_pieces_keep_a_fat_start_with_all_its_corners():
    with precision(200):
        flow = Flow(turning, [arb(1, 0.01), arb(0, 0.01)], Fraction(1, 4), 3)
        piece, t = flow.piece(7), arb(2)
        for x0 in (arb("0.991"), arb(1), arb("1.009")):
            for v0 in (arb("-0.009"), arb("0.009")):
                x, v = piece.at(t - piece.begin)
                assert x.contains(x0 * t.cos() + v0 * t.sin())
                assert v.contains(v0 * t.cos() - x0 * t.sin())


def test_pieces_join_to_forty_digits_over_many_steps():
    with precision(256):
        flow = Flow(turning, [arb(1), arb(0)], Fraction(1, 4), 40)
        piece = flow.piece(40)
        x = piece.at(arb_of(Fraction(81, 8)) - piece.begin)[0]
        assert x.rad() < 1e-55
        assert x.overlaps(arb_of(Fraction(81, 8)).cos())


def test_an_enclosure_holds_the_solution_and_a_step_past_the_pole_has_none():
    with precision(200):
        box = enclosure(squares, [arb(1)], arb(1) / 8)
        assert box is not None
        assert box[0].contains(arb(1))
        assert box[0].contains(1 / (1 - arb(1) / 8))
        assert enclosure(squares, [arb(1)], arb(1)) is None


def test_a_solution_that_runs_into_a_pole_is_not_certified_there():
    with precision(200):
        flow = Flow(squares, [arb(1)], Fraction(1, 4), 8)
        with pytest.raises(NotCertifiedError, match=r"enclosed up to 0\.99"):
            flow.piece(3000)


def test_first_zero_takes_the_first_of_two_and_skips_the_start():
    with precision(256):
        rising_from_zero = arb_poly([0, 6, -5, 1])
        zero = first_zero(rising_from_zero, arb(0), arb(10))
        assert zero is not None
        assert zero.contains(arb(2))
        assert zero.rad() < 1e-60
        assert first_zero(rising_from_zero, arb(0), arb("1.9")) is None


def test_first_zero_of_the_cosine_is_half_pi():
    with precision(256):
        piece = Flow(turning, [arb(1), arb(0)], Fraction(1, 2), 60).piece(3)
        zero = first_zero(piece.polynomials[0], arb(0), piece.length)
        assert zero is not None
        assert (piece.begin + zero).overlaps(arb.pi() / 2)


def test_positivity_is_seen_through_overestimates_and_refused_where_it_fails():
    with precision(128):
        assert is_positive(lambda x: x * x - x + arb("0.26"), arb(0), arb(1))
        assert not is_positive(lambda x: x * x - x + arb("0.2499"), arb(0), arb(1))
