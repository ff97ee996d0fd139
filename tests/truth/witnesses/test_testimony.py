"""A witness confirms what is true and denies what is not, shares no code with what it witnesses, and is found by its file."""

from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.core.truth import Ball
from refdem.truth import load
from refdem.truth.certified.sources import ROOT, case_files, closure
from refdem.truth.certified.writing import row
from refdem.truth.witnesses import testimony as witnessing
from refdem.truth.witnesses.testimony import witness_files, witnesses

SHARED = {"truth/balls.py", "truth/exact.py"}
"""Conversions of exact numbers alone."""


def set_of(case: str):
    """Its cheapest certified set, and the rows up to its first time."""
    one = min((one for one in load(case) if one.witnessed), key=lambda one: len(one.parameters))
    first = min(value.t for value in one.values if value.t is not None)
    rows = [(None if v.t is None else str(v.t), v.quantity, v.mid, v.radius, None) for v in one.values if v.t in (None, first)]
    given = {name: text for name, text in one.parameters.items() if text}
    return discovery.case(case).at(**given).p, rows


def test_every_witness_is_of_a_case_of_the_catalogue() -> None:
    assert set(witnesses()) <= set(discovery.names("cases")) | {"neglected-gyroscopic"}
    assert len(witnesses()) >= 20


@pytest.mark.parametrize("case", sorted(set(witnesses()) & set(discovery.names("cases"))))
def test_a_witness_shares_no_code_with_the_truth(case: str) -> None:
    own = {p.relative_to(ROOT).as_posix() for p in closure(case_files(case))}
    its = {p.relative_to(ROOT).as_posix() for p in closure(witness_files(case))}
    assert {name for name in own & its if not name.startswith("cases/")} <= SHARED


@pytest.mark.parametrize("case", ["pendulum", "viscous-oscillator", "captured-mass", "logistic", "billiards"])
def test_a_value_that_is_wrong_in_its_25th_digit_is_denied(case: str) -> None:
    p, rows = set_of(case)
    said = witnessing.testimony(case, p, rows)
    assert said is not None
    assert said["denied"] == []
    assert said["digits"] >= 30
    wrong = [(t, name, str(Fraction(mid) + Fraction(2, 10**24) * max(1, abs(Fraction(mid)))), *rest) for t, name, mid, *rest in rows]
    again = witnessing.testimony(case, p, wrong)
    assert again is not None
    assert len(again["denied"]) == said["values"]


def test_a_case_without_a_witness_has_no_testimony() -> None:
    assert witnessing.testimony("quaternions", {}, [row(None, "x", Ball(Fraction(1), Fraction(0)))]) is None


def test_heyoka_in_multiprecision_says_the_same_of_a_driven_oscillator() -> None:
    """x'' = mu (1 - x^2) x' - x + p sin(w t) at t = 10: heyoka 7.13 with fp_type=real of 233 bits, tolerance 2^-200, 71 digits printed."""
    (found,) = [one for one in load("van-der-pol") if one.label == "van-der-pol"]
    for name, text in (
        ("x", "-1.35138048325573609547773046227893647231791501935215691355419947692823301"),
        ("v", "0.744736106706547023962363044752261988576845670050125361739533575659011326"),
    ):
        low, high = found.value(name, "10").interval
        assert low <= Fraction(text) <= high
