"""Quaternions and matrices of balls."""

from itertools import product

import pytest
from flint import arb

from refdem.truth import rotation
from refdem.truth.balls import UndecidedError

X, Y, Z = ([arb(int(i == k)) for i in range(3)] for k in range(3))


def close(a, b):
    return all(x.overlaps(y) for x, y in zip(a, b, strict=True))


def test_a_quarter_turn_about_z_takes_x_to_y():
    q = rotation.turn(Z, arb.pi() / 2)
    assert close(rotation.rotated(q, X), Y)
    assert close(rotation.applied(rotation.matrix(q), X), Y)


@pytest.mark.parametrize("signs", list(product((-1, 1), repeat=3)))
@pytest.mark.parametrize("largest", range(4))
def test_a_matrix_gives_back_its_quaternion_whichever_component_is_largest(largest, signs):
    q = [arb(7) / 10 if i == largest else arb(1) / (2 + i) for i in range(4)]
    q = [x if i == 0 else x * signs[i - 1] for i, x in enumerate(q)]
    size = rotation.dot(q, q).sqrt()
    unit = rotation.upright([x / size for x in q])
    assert close(rotation.upright(rotation.quaternion(rotation.matrix(unit))), unit)


def test_turns_follow_the_product_of_quaternions():
    p = rotation.turn(X, arb("0.3"))
    q = rotation.turn(Y, arb("-1.2"))
    both = rotation.product(rotation.matrix(p), rotation.matrix(q))
    for row, expected in zip(rotation.matrix(rotation.times(p, q)), both, strict=True):
        assert close(row, expected)


def test_sign_of_an_attitude_is_that_of_its_first_component_that_is_not_zero():
    assert rotation.upright([arb(0), arb(-1), arb(0), arb(2)])[1] == 1
    with pytest.raises(UndecidedError, match="sign"):
        rotation.upright([arb(0, 1e-9), arb(1), arb(0), arb(0)])
