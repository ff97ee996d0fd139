"""A number that follows from parameters is enclosed at every precision, is never rounded, and its
comparisons are proved.
"""

import operator
import random
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.reals import Real, Root, cosine, logarithm, near, pi, root, sine

PRECISIONS = (64, 128, 256, 512, 1024)
ROUNDED = (0.5, np.float64(0.5), Decimal("0.5"), np.int64(2), True, "1/2", 1j)


def grown(rng):
    """A random expression of exact numbers and of numbers that follow from them."""
    leaves = [
        pi(),
        root(Fraction(2)),
        root(Fraction(3, 5)),
        sine(Fraction(1, 3)),
        cosine(Fraction(7, 4)),
        logarithm(Fraction(5)),
    ]
    value = rng.choice(leaves)
    for _ in range(rng.randint(1, 12)):
        other = rng.choice(
            [*leaves, Fraction(rng.randint(1, 9), rng.randint(1, 9)), rng.randint(1, 5)]
        )
        operation = rng.choice([operator.add, operator.sub, operator.mul, operator.truediv])
        is_first = operation is operator.truediv or rng.random() < 0.5
        if is_first:
            value = operation(value, other)
        else:
            value = operation(other, value)
    return value


@pytest.mark.parametrize("seed", range(40))
def test_balls_of_every_precision_hold_the_same_number(seed):
    value = grown(random.Random(seed))
    balls = []
    for bits in PRECISIONS:
        with precision(bits):
            balls.append(arb_of(value))
    with precision(2048):
        finite = [ball for ball in balls if ball.is_finite()]
        assert all(one.overlaps(other) for one in finite for other in finite)
    assert balls[-1].rad() < 2.0**-900 * (1 + abs(balls[-1].mid()))


def test_products_of_roots_are_rational_where_they_are():
    two = root(Fraction(2))
    assert isinstance(two, Root)
    assert two * two == 2
    assert (two / 3) ** 2 == Fraction(2, 9)
    assert root(Fraction(8)) / two == 2
    assert two * root(Fraction(1, 2)) == 1
    assert -two * two == -2
    assert root(Fraction(9, 16)) == Fraction(3, 4)
    assert 3 / root(Fraction(9, 2)) * two == 2


def test_comparisons_are_proved_and_equality_is_not_guessed():
    assert pi() > Fraction(314159265358979323846, 10**20)
    assert pi() < Fraction(314159265358979323847, 10**20)
    assert Fraction(22, 7) > pi() > 3
    assert sine(Fraction(1, 10**80)) < Fraction(1, 10**80)
    assert (pi() - 4).sign() == -1
    with pytest.raises(UndecidedError):
        _ = pi() - pi() > 0


def test_what_is_exactly_nothing_stays_exact():
    assert sine(Fraction(0)) == 0
    assert cosine(Fraction(0)) == 1
    assert logarithm(Fraction(1)) == 0
    assert pi() * 0 == 0
    assert 0 / pi() == 0
    assert pi() + 0 is not None


@pytest.mark.parametrize("rounded", ROUNDED, ids=str)
def test_a_rounded_number_is_refused_by_the_door_and_by_every_operation(rounded):
    with pytest.raises(TypeError, match="expected an exact rational"):
        arb_of(rounded)
    for operation in (operator.add, operator.sub, operator.mul, operator.truediv, operator.lt):
        for pair in ((pi(), rounded), (rounded, pi())):
            with pytest.raises(TypeError):
                operation(*pair)


def test_scenes_get_the_nearest_binary64():
    assert float(pi()) == np.pi
    assert float(root(Fraction(2))) == np.sqrt(2.0)
    assert near(Fraction(1, 3)) == Fraction(1, 3)
    tiny = sine(Fraction(1, 10**90))
    assert float(tiny) == 1e-90
    # Most of the digits of both cancel: 128 bits do not know the difference, and more are taken.
    assert float(cosine(Fraction(1, 10**30)) - 1) == -5e-61


def test_a_ball_is_made_anew_at_each_precision_and_kept():
    asked = []

    def enclosed():
        asked.append(len(asked))
        return arb_of(Fraction(1, 3))

    number = Real(enclosed)
    for bits in (64, 64, 128, 64):
        with precision(bits):
            number.ball()
    assert len(asked) == 2
