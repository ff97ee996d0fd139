"""Dual numbers, exact ones and balls, against differences of the same formulas."""

import operator
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest
from flint import arb

from refdem.truth.balls import arb_of, precision
from refdem.truth.dual import DualBall, ExactDual, atan2, parameters, rational_root, slopes_of
from refdem.truth.traced_field import Program, traced

STEP = Fraction(1, 2**60)
FORMULAS = {
    "sum": lambda x, y: x + y - 3 * x + 2 - y * 5,
    "product": lambda x, y: x * y * x + 2 * y,
    "quotient": lambda x, y: (x + 1) / y + 1 / x + y / 3,
    "power": lambda x, y: x**3 * y**4 + x**-2,
    "general power": lambda x, y: x**y,
    "root": lambda x, y: (x * x + y * y).sqrt() + x.rsqrt(),
    "inverse hyperbolic sine": lambda x, y: (x / y).asinh(),
    "negative": lambda x, y: -x * y - (4 - x) + (+y) - abs(y) + abs(x),
    "waves": lambda x, y: x.sin() * y.cos() + (x * y).sin_cos()[0] + (x / y).tan(),
    "exponentials": lambda x, y: (x * y).exp() + x.log() * y,
    "hyperbolic": lambda x, y: x.sinh() + (x * y).cosh() + y.tanh(),
    "inverse waves": lambda x, y: x.asin() + (x / 2).acos() * y + (x * y).atan(),
    "angle": lambda x, y: atan2(x, y) + atan2(y, x) * atan2(x, x + 1),
    "smaller and larger": lambda x, y: x.min(y) * 2 + y.max(x) + x.max(arb(5)) + y.min(arb(5)),
    "beside balls": lambda x, y: arb(2) * x - arb(3) / y + (arb(5) - x) / arb(7) + arb(1) * y,
}
PLACE = (Fraction(5, 7), Fraction(-3, 2))


@pytest.mark.parametrize("name", FORMULAS)
def test_derivatives_are_those_of_differences(name: str) -> None:
    formula = FORMULAS[name]
    with precision(256):
        found = formula(*parameters([arb_of(x) for x in PLACE]))
        assert found.value.overlaps(formula(*(arb_of(x) for x in PLACE)))
        for i in (0, 1):
            ahead, behind = (
                formula(*(arb_of(x + sense * STEP * (i == j)) for j, x in enumerate(PLACE)))
                for sense in (1, -1)
            )
            slope = (ahead - behind) / arb_of(2 * STEP)
            assert abs(slope - found.slopes[i]) < 1e-30


def test_powers_of_balls_that_hold_zero_are_numbers() -> None:
    (x,) = parameters([arb(0, 1e-3)])
    cube = x**3
    assert abs(cube.value) < 2e-9
    assert abs(cube.slopes[0]) < 4e-6


RATIONAL = {
    "sum": lambda x, y: x + y - 3 * x + 2 - y * 5 + Fraction(1, 3) - (1 - x),
    "product": lambda x, y: x * y * x + 2 * y + Fraction(2, 3) * x,
    "quotient": lambda x, y: (x + 1) / y + 1 / x + y / 3 + Fraction(1, 7) / y,
    "power": lambda x, y: x**3 * y**4 + y**-2 + x**0,
    "negative": lambda x, y: -x * y + abs(y) * abs(x) - (+x),
}


@pytest.mark.parametrize("name", RATIONAL)
def test_exact_derivatives_are_those_of_the_same_formula_in_balls(name: str) -> None:
    formula = RATIONAL[name]
    exact = formula(ExactDual(PLACE[0], (1, 0)), ExactDual(PLACE[1], (0, 1)))
    assert exact == formula(*PLACE)
    ahead, behind = (
        tuple(formula(*(x + sense * STEP * (i == j) for j, x in enumerate(PLACE))) for i in (0, 1))
        for sense in (1, -1)
    )
    for i in (0, 1):
        assert abs((ahead[i] - behind[i]) / (2 * STEP) - exact.slopes[i]) < Fraction(1, 10**30)
        assert slopes_of(arb_of(exact))[i].overlaps(arb_of(exact.slopes[i]))


def test_a_rational_root_has_its_derivative() -> None:
    root = rational_root(ExactDual(Fraction(9, 4), (1, 0)))
    assert root == Fraction(3, 2)
    assert slopes_of(root) == (Fraction(1, 3), 0)
    assert rational_root(Fraction(0)) == 0
    assert rational_root(Fraction(2)) is None
    assert rational_root(ExactDual(0, (1,))) is None


@pytest.mark.parametrize("function", ["gamma", "zeta", "erf", "agm", "root"])
def test_a_function_without_a_rule_is_refused(function: str) -> None:
    """It would have given a ball without derivatives, which counts as one that depends on
    nothing.
    """
    (x,) = parameters([arb(2)])
    with pytest.raises(TypeError, match=f"derivative of {function}"):
        getattr(x, function)(arb(1))


def test_the_derivative_of_a_size_where_it_may_be_zero_is_refused() -> None:
    (x,) = parameters([arb(0, 1e-3)])
    with pytest.raises(TypeError, match="holds 0"):
        abs(x)


@pytest.mark.parametrize("operate", [operator.add, operator.sub, operator.mul, operator.truediv])
def test_an_operation_with_a_rounded_number_is_refused(operate: Callable[..., Any]) -> None:
    with pytest.raises(TypeError):
        operate(ExactDual(2, (1,)), 0.5)


def test_constants_of_a_field_with_the_same_value_keep_their_own_derivatives() -> None:
    """Both numbers are 1, and 1 as a factor or 0 as a summand is left out of a trace only where
    nothing depends on it.
    """
    one = ExactDual(1, (1, 0))
    other = ExactDual(1, (0, 1))
    nothing = ExactDual(0, (1, 1))

    def field(y):
        return [y[0] * one + y[0] * y[0] * other + nothing]

    (output,), _ = traced(field, 1)
    (value,) = Program([output]).run([arb(3)])
    assert value == 12
    assert slopes_of(value) == (4, 10)
    _, (row,) = traced(lambda y: [*field(y[:1]), 0, 0][:1], 3, range(1, 3))
    slopes = Program(row).run([arb(3), arb(1), arb(1)])
    assert slopes == [7, 4, 10]


def test_a_dual_ball_is_a_ball() -> None:
    (x,) = parameters([arb(2)])
    assert isinstance(x, arb)
    assert x > 1
    assert isinstance(x.mid(), arb)
    assert not isinstance(x.mid(), DualBall)
