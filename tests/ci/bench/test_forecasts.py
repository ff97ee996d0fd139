"""ci/bench/forecasts.py: which forecasts hold, and what it compares."""

import random
from fractions import Fraction

import pytest
from forecasts import PATIENCE, Comparison, compared, comparison


@pytest.mark.parametrize("proof", [0.67, 2.0, 5.9])
def test_a_forecast_within_a_factor_of_3_holds(proof):
    assert Comparison("lorenz", {}, Fraction(1), 2.0, 0.1, proof).holds()


@pytest.mark.parametrize("proof", [0.66, 6.1, PATIENCE * 2.0])
def test_a_forecast_beyond_a_factor_of_3_is_marked(proof):
    one = Comparison("lorenz", {}, Fraction(1), 2.0, 0.1, proof)
    assert not one.holds()
    assert one.line().startswith("!")


def test_a_proof_that_is_refused_is_no_miss():
    assert Comparison("lorenz", {}, Fraction(1), 2.0, 0.1, 0.0, "refused: a corner").holds()


def test_what_costs_nothing_is_not_compared():
    assert compared("pendulum", {}, Fraction(1)) is None
    assert comparison("harmonic-oscillator", random.Random(1)) is None
