"""Hertz's contact with a tangential spring: against Taylor integration of the law itself, limits,
and mirror images.
"""

from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import atan

import pytest
from flint import arb

from refdem.cases.impact_benchmarks import member
from refdem.core import discovery
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.impact_benchmarks.mindlin_wall import Sliding
from refdem.truth.mindlin_spring import INWARD, MindlinSpring
from refdem.truth.power_contact import PowerContact
from refdem.truth.witnesses.members import Mindlin

TINY = Fraction(1, 10**30)
MU = Fraction("0.092")


@cache
def case(angle, **given):
    return discovery.case("impact-benchmarks").at(member="dem-05-mindlin", angle=angle, **given)


def numbers(instance):
    return member("dem-05-mindlin").values(instance.p)


@pytest.mark.parametrize(("angle", "kinds"), [("1/4", 4), ("-0.05", 4), ("1/2", 3)])
def test_every_phase_is_that_of_the_law_by_taylor_series(angle, kinds):
    instance = case(angle)
    truth = instance.truth()
    if Fraction(angle) < 0:
        side = -1
    else:
        side = 1
    with precision(256):
        law = Mindlin(vars(numbers(instance)))
        radius = law.radius
        assert len(truth.phases()) == kinds
        seen = 0
        for solution, end in law.phases():
            for part in (1 / 7, 2 / 3):
                begin = float(solution.begins[0])
                near = begin + (float(end) - begin) * part
                apart = (float(end) - begin) / 1000
                moment = Fraction(float(solution.at(arb(near))[2]))
                passed = solution.crossing(lambda y, m=moment: y[2] - arb_of(m), near, apart)
                w, v, _, vy, spin, y, _ = solution.at(passed)
                expected = {
                    "r.x": w * w - radius,
                    "v.x": v,
                    "r.y": side * y,
                    "v.y": side * vy,
                    "omega.z": side * spin / radius,
                }
                found = truth.at(moment)
                assert {
                    name: float(abs(value - arb_of(found[name].mid))) < 1e-30
                    for name, value in expected.items()
                } == dict.fromkeys(expected, True)
            seen += 1
        assert seen == kinds - sum(_goes_on(truth))


def _goes_on(truth):
    kinds = [isinstance(phase.motion, Sliding) for phase in truth.phases()]
    return [not a and not b for a, b in pairwise(kinds)]


def test_it_slides_from_touch_where_the_tangent_passes_friction_times_the_ratio_of_stiffnesses():
    v = numbers(case("1/4"))
    limit = atan(float(v.friction * v.hertz / v.mindlin))
    assert v.hertz / v.mindlin == Fraction(2, 3) * (2 - v.poisson) / (2 * (1 - v.poisson))
    with precision(256):
        kinds = [
            isinstance(case(repr(limit * f)).truth().phases()[0].motion, Sliding)
            for f in (0.999, 1.001)
        ]
    assert kinds == [False, True]


def test_gross_sliding_takes_five_halves_of_twice_friction_as_spin():
    instance = case("1.2")
    v = numbers(instance)
    last = instance.truth().scalars()
    assert abs(last["rebound_spin"].mid + 5 * MU * v.normal / v.radius) < TINY * 1000
    assert abs(last["rebound_across"].mid - (v.across - 2 * MU * v.normal)) < TINY


def test_the_equation_of_the_stretch_holds_on_every_leg():
    with precision(256):
        spring = MindlinSpring(
            PowerContact(Fraction(1, 8), Fraction(1000), Fraction(3, 2), arb(1)), Fraction(5, 4)
        )
        step = arb(2) ** -60
        for leg in range(3):
            low, high = spring.ends(leg)
            x = low + (high - low) / 3
            for n in (0, 1):
                value = spring.basis(leg, x)[n]
                slope = spring.basis(leg, x)[2 + n]
                before, after = (spring.basis(leg, x + sign * step)[n] for sign in (-1, 1))
                assert abs((after - before) / (2 * step) - slope) < 1e-30
                assert (
                    abs((after - 2 * value + before) / step**2 - spring.bent(leg, x, value, slope))
                    < 1e-30
                )
        assert float(spring.pace(INWARD, arb(0))) * float(spring.contact.unit) == 1
