"""The witness itself: its remainder is proven, and here it is seen to be needed."""

from fractions import Fraction

import pytest
from flint import arb

from refdem.truth.balls import arb_of, precision
from tests.quadratic_flows import Quadratic, body_flow, pendulum_flow

SQUARE = Quadratic([[(arb(1), 0, 0)]])


@pytest.mark.parametrize("order", [1, 2, 5, 40])
@pytest.mark.parametrize("t", [Fraction(1, 2), Fraction(3, 2), Fraction(-1)])
def test_balls_contain_the_solution_at_any_order(order, t):
    # y' = y^2, y(0) = 1/2: y = 1/(2 - t), its own majorant, so that the remainder is used up wholly
    with precision(200):
        (y,) = SQUARE.flow([arb(1) / 2], t, order=order)
        assert y.contains(1 / (2 - arb_of(t)))


def test_the_midpoint_alone_misses_the_solution_at_low_order():
    with precision(200):
        (y,) = SQUARE.flow([arb(1) / 2], Fraction(1, 2), order=2)
        true = 1 / arb("1.5")
        assert not y.mid().overlaps(true)
        assert 1e-3 < y.rad() < 1e-1


def test_a_fat_start_carries_all_that_lies_in_it():
    with precision(200):
        (y,) = SQUARE.flow([arb(0.5, 0.01)], Fraction(1), order=30)
        for start in ("0.49", "0.495", "0.51"):
            assert y.contains(1 / (1 / arb(start) - 1))


def test_a_body_about_a_principal_axis_turns_at_its_rate():
    with precision(200):
        j = tuple(map(Fraction, (1, 2, 3)))
        omega, q = body_flow(
            j,
            (Fraction(0), Fraction(3, 2), Fraction(0)),
            (Fraction(2), *[Fraction(0)] * 3),
            Fraction(2),
            order=40,
        )
        assert [
            x.overlaps(v) for x, v in zip(omega, (arb(0), arb("1.5"), arb(0)), strict=True)
        ] == [True] * 3
        assert q[0].overlaps(arb("1.5").cos())
        assert q[2].overlaps(arb("1.5").sin())
        assert q[2].rad() < 1e-20


def test_a_pendulum_on_its_separatrix_rises_as_tanh():
    with precision(200):
        cosine, sine, rate = pendulum_flow(
            arb(0), Fraction(6), Fraction(9), Fraction(1, 2), order=40
        )
        half = arb("1.5").sinh().atan()
        assert cosine.overlaps((2 * half).cos())
        assert sine.overlaps((2 * half).sin())
        assert rate.overlaps(6 / arb("1.5").cosh())
