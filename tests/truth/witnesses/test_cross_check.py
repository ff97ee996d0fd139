"""A witness confirms what is true and denies what is not, shares no code with what it witnesses,
and is found by its file.
"""

from fractions import Fraction

import pytest

from refdem.certification.reproof import given_of
from refdem.core import discovery
from refdem.core.selection import Selection
from refdem.core.truth import Ball
from refdem.truth import load
from refdem.truth.certified.sources import ROOT, case_files, closure
from refdem.truth.certified.writing import row, rows
from refdem.truth.witnesses import cross_check
from refdem.truth.witnesses.cross_check import witness_files, witnesses

SHARED = {"truth/balls.py", "truth/dual.py", "truth/exact.py"}
"""Conversions of exact numbers alone, and those that carry their derivatives."""


def set_of(case: str):
    """Its cheapest certified set, and the rows up to its first time."""
    one = min((one for one in load(case) if one.witnessed), key=lambda one: len(one.parameters))
    first = min(value.t for value in one.values if value.t is not None)
    rows = [
        (None if v.t is None else str(v.t), v.quantity, v.mid, v.radius, None)
        for v in one.values
        if v.t in (None, first)
    ]
    case_ = discovery.case(case)
    return case_.meant(case_.at(**given_of(one)).p), rows


def test_every_witness_is_of_a_case_of_the_catalogue() -> None:
    assert set(witnesses()) <= set(discovery.names("cases")) | {"neglected-gyroscopic"}


def test_every_case_has_a_witness_and_every_set_was_confirmed_by_it() -> None:
    """Also every set that is asked for: what nobody else can say is no truth."""
    cases = {
        name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
    }
    assert sorted(cases - set(witnesses())) == []
    assert [one.label for one in load() if not one.witnessed] == []


@pytest.mark.parametrize(
    "case",
    [
        "bifurcations",
        "degrees-of-freedom",
        "moments-of-inertia",
        "poincare-sections",
        "quaternions",
        "rotations",
    ],
)
def test_what_has_no_time_is_confirmed_to_the_last_value(case: str) -> None:
    for one in load(case):
        rows = [(None, v.quantity, v.mid, v.radius, None) for v in one.values]
        said = cross_check.cross_checked(case, discovery.case(case).at(**given_of(one)).p, rows)
        assert said is not None
        assert (said["values"], said["denied"]) == (len(rows), [])


@pytest.mark.parametrize(
    "given",
    [
        {"v0": "3/4", "x0": "0"},
        {"v0": "-3", "friction_force": "1/3", "stiffness": "2"},
        {"v0": "1/10", "x0": "1/20"},
    ],
)
def test_a_mass_that_starts_with_a_velocity_is_followed_through_its_first_turn(
    given: dict[str, str],
) -> None:
    instance = discovery.case("coulomb-oscillator").at(**given)
    times = [Fraction(1, 3), Fraction(2), Fraction(6)]
    found = [row(t, name, ball) for t in times for name, ball in instance.truth().at(t).items()]
    said = cross_check.cross_checked("coulomb-oscillator", instance.p, found)
    assert said is not None
    assert (said["values"], said["denied"]) == (6, [])


@pytest.mark.parametrize(
    "given",
    [
        {"beta": "-1/20", "delta": "1/50", "f0": "1/10"},
        {"beta": "-1/5", "delta": "1/20", "f0": "1/10", "amplitude": "9/10"},
    ],
)
def test_folds_of_a_spring_that_softens_are_confirmed_by_discriminants(
    given: dict[str, str],
) -> None:
    instance = discovery.case("bifurcations").at(**given)
    found = [row(None, name, ball) for name, ball in instance.truth().scalars().items()]
    said = cross_check.cross_checked("bifurcations", instance.p, found)
    assert said is not None
    assert (said["values"], said["denied"]) == (16, [])


@pytest.mark.parametrize(("exponent", "amplitude"), [("3/2", "5/4"), ("9/5", "-2"), ("7/3", "1/3")])
def test_a_broken_power_is_followed_through_its_centre(exponent: str, amplitude: str) -> None:
    instance = discovery.case("power-oscillator").at(exponent=exponent, amplitude=amplitude)
    truth = instance.truth()
    times = [Fraction(1, 3), Fraction(5, 2), Fraction(4), Fraction(11)]
    found = [
        row(None, "period", truth.scalars()["period"]),
        *(row(t, name, b) for t in times for name, b in truth.at(t).items()),
    ]
    said = cross_check.cross_checked("power-oscillator", instance.p, found)
    assert said is not None
    assert (said["values"], said["denied"]) == (9, [])


@pytest.mark.parametrize(
    ("member", "values"),
    [
        ("co-2", 18),
        ("co-7", 29),
        ("dem-01", 20),
        ("dem-03", 36),
        ("dem-04", 22),
        ("dem-05", 22),
        ("dem-05-mindlin", 21),
        ("contact-path", 24),
        ("contact-path-turned", 24),
    ],
)
def test_members_of_the_impact_benchmarks_are_confirmed_in_contact_and_after(
    member: str, values: int
) -> None:
    case = discovery.case("impact-benchmarks")
    instance = case.at(member=member)
    truth = instance.truth().refined(36)
    times = [
        Fraction(round(float(instance.scales.duration) * part * 2**40), 2**40)
        for part in (0.2, 0.7)
    ]
    found, _ = rows(truth, times)
    said = cross_check.cross_checked("impact-benchmarks", case.meant(instance.p), found)
    assert said is not None
    assert (said["values"], said["denied"]) == (values, [])


def test_a_balance_that_is_off_confirms_nothing() -> None:
    case = discovery.case("newtons-first-law")
    meant = dict(case.meant(case.at(member="spheres").p))
    rows = [("1", "r1.z", "0", "0", None)]
    assert cross_check.cross_checked("newtons-first-law", meant, rows) is not None
    low, high = meant["heights"]
    assert (
        cross_check.cross_checked(
            "newtons-first-law", meant | {"heights": [low, high + Fraction(1, 1024)]}, rows
        )
        is None
    )


@pytest.mark.parametrize("case", sorted(set(witnesses()) & set(discovery.names("cases"))))
def test_a_witness_shares_no_code_with_the_truth(case: str) -> None:
    own = {p.relative_to(ROOT).as_posix() for p in closure(case_files(case))}
    its = {p.relative_to(ROOT).as_posix() for p in closure(witness_files(case))}
    assert {name for name in own & its if not name.startswith("cases/")} <= SHARED


@pytest.mark.parametrize(
    "case", ["pendulum", "viscous-oscillator", "captured-mass", "logistic", "billiards"]
)
def test_a_value_that_is_wrong_in_its_25th_digit_is_denied(case: str) -> None:
    p, rows = set_of(case)
    said = cross_check.cross_checked(case, p, rows)
    assert said is not None
    assert said["denied"] == []
    assert said["digits"] >= 30
    wrong = [
        (t, name, str(Fraction(mid) + Fraction(2, 10**24) * max(1, abs(Fraction(mid)))), *rest)
        for t, name, mid, *rest in rows
    ]
    again = cross_check.cross_checked(case, p, wrong)
    assert again is not None
    assert len(again["denied"]) == said["values"]


def test_a_case_without_a_witness_has_no_cross_check() -> None:
    assert (
        cross_check.cross_checked(
            "nobody-knows", {}, [row(None, "x", Ball(Fraction(1), Fraction(0)))]
        )
        is None
    )


def test_heyoka_in_multiprecision_says_the_same_of_a_driven_oscillator() -> None:
    """x'' = mu (1 - x^2) x' - x + p sin(w t) at t = 10: heyoka 7.13 with fp_type=real of 233 bits,
    tolerance 2^-200, 71 digits printed.
    """
    (found,) = [one for one in load("van-der-pol") if one.label == "van-der-pol"]
    for name, text in (
        ("x", "-1.35138048325573609547773046227893647231791501935215691355419947692823301"),
        ("v", "0.744736106706547023962363044752261988576845670050125361739533575659011326"),
    ):
        low, high = found.value(name, "10").interval
        assert low <= Fraction(text) <= high
