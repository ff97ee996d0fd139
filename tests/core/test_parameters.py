"""Parameters are exact, bounded, and say what is wrong with them."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core.parameters import Parameter, Parameters, settings
from refdem.errors import UsageError

DECLARED = (
    Parameter(name="mass", default="1", unit="kg", doc="mass", above=0),
    Parameter(name="inertia", default="1,2,3", unit="kg m^2", doc="moments", shape=(3,), above=0),
    Parameter(name="branch", default="R", unit="1", doc="lever arm", choices=("R", "R-d")),
    Parameter(name="spins", default="0,0,0,0,0,0", unit="rad/s", doc="spins", shape=(2, 3)),
    Parameter(name="count", default="2", unit="1", doc="how many", at_least=2, whole=True),
    Parameter(name="part", default="0", unit="1", doc="below 1", at_most=0.999999),
)


def test_numbers_are_exact_and_floats_are_their_rounding():
    p = Parameters(DECLARED, {"mass": "0.1", "inertia": "1/3,1,1"})
    assert p["mass"] == Fraction(1, 10)
    assert p.mass == 0.1
    assert p["inertia"][0] == Fraction(1, 3)
    assert np.array_equal(p.inertia, [1 / 3, 1.0, 1.0])
    assert p.spins.shape == (2, 3)


@pytest.mark.parametrize("text", ["3/2", "0.1", "1e-3", "-2", "+.5", "7/3"])
def test_text_of_a_value_reads_back_as_the_same_value(text):
    free = Parameter(name="x", default="0", unit="1", doc="any")
    p = Parameters((free,), {"x": text})
    assert Parameters((free,), p.texts())["x"] == p["x"] == Fraction(text)


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("mass", "0", "> 0"),
        ("mass", "-1", "> 0"),
        ("mass", "nan", "finite decimal or fraction"),
        ("mass", "inf", "finite decimal or fraction"),
        ("mass", "1e9999", "finite decimal or fraction"),
        ("mass", "1/0", "denominator is zero"),
        ("mass", "__import__('os')", "finite decimal or fraction"),
        ("inertia", "1,2", "expected 3"),
        ("inertia", "1,2,0", "> 0"),
        ("branch", "S", "one of R, R-d"),
        ("mass", "1e400", "between 1e-100 and 1e100"),
        ("mass", "1e-400", "between 1e-100 and 1e100"),
        ("mass", "\uff11", "finite decimal or fraction"),
        ("count", "2.5", "whole"),
        ("part", "0.9999991", "<= 0.999999"),
        ("mas", "1", "did you mean 'mass'"),
    ],
)
def test_bad_values_are_refused_with_what_came_and_what_was_expected(name, text, says):
    with pytest.raises(UsageError, match=name) as caught:
        Parameters(DECLARED, {name: text})
    assert says in str(caught.value)


def test_only_changed_values_are_in_the_label():
    assert Parameters(DECLARED, {"mass": "1.0", "branch": "R-d"}).changed() == {"branch": "R-d"}


def test_a_bound_is_the_decimal_that_the_source_has_and_not_the_double_next_to_it():
    assert Parameters(DECLARED, {"part": "0.999999"})["part"] == Fraction(999999, 1000000)


def test_a_name_that_comes_twice_with_two_values_is_refused():
    assert settings(["mass=1", "mass=1"]) == {"mass": "1"}
    with pytest.raises(UsageError, match="twice"):
        settings(["mass=1", "mass=2"])
