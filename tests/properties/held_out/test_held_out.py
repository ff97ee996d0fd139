"""Truth at parameters that no certified set has, to 40 digits, against values.txt, which
by_mpmath.py has made: no code is shared. A case that is not in that file is held to its witness
instead, which shares no code with its truth either, at parameters drawn at random.
"""

import json
import random
from collections import defaultdict
from fractions import Fraction
from pathlib import Path

import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.core.selection import Selection
from refdem.truth import load
from refdem.truth.certified.writing import rows
from refdem.truth.witnesses import cross_check

PRINTED = Fraction(1, 10**44)
"""Of its size (at least 1): mpmath's 60 digits leave 48 to be printed; four of them are left to its
rounding.
"""


def questions():
    """(case, parameters as JSON): {time: {quantity: value}}."""
    found = defaultdict(lambda: defaultdict(dict))
    for line in (Path(__file__).parent / "values.txt").read_text().splitlines():
        name, given, t, quantity, value = json.loads(line)
        found[name, json.dumps(given)][t][quantity] = Fraction(value)
    return found


QUESTIONS = questions()


def misses(truth, asked):
    """Quantities whose balls do not hold the value, or are wider than 40 digits."""
    missed = []
    for t, values in asked.items():
        if t is None:
            balls = truth.scalars()
        else:
            balls = truth.at(Fraction(t))
        for name, value in values.items():
            ball = balls[name]
            slack = PRINTED * max(1, abs(value))
            if ball.radius > Fraction(1, 10**40) or abs(ball.mid - value) > ball.radius + slack:
                missed.append((t, name, float(abs(ball.mid - value))))
    return missed


@pytest.mark.parametrize(("name", "given"), QUESTIONS)
def test_held_out_parameters_meet_mpmath_in_forty_digits(name, given):
    instance = discovery.case(name).at(**json.loads(given))
    assert instance.label not in {one.label for one in load(name)}, "it is stored, not held out"
    assert misses(instance.truth().refined(40), QUESTIONS[name, given]) == []


CASES = {
    name for name in discovery.own_names("cases") if not isinstance(discovery.case(name), Selection)
}
OTHERS = sorted(CASES - {name for name, _ in QUESTIONS})
BRIEF = {"coupled-pendulums": {"duration": "3/2"}}
"""Motions that are followed for a part of their time alone: nothing happens in them that is not in
all of it, and witness and proof take time in proportion.
"""


def test_every_case_with_truth_is_asked():
    assert {name for name, _ in QUESTIONS} | set(OTHERS) == CASES
    assert set(OTHERS) <= set(cross_check.witnesses())


def drawn(case, seed):
    """The case with every number between half and twice its default, as a fraction."""
    rng = random.Random(f"{case.id} {seed}")
    given = {}
    for parameter in case.parameters:
        default = parameter.default
        if parameter.choices or parameter.whole or parameter.shape or not default:
            continue
        factor = Fraction(rng.randint(500, 2000), 1000)
        value = Fraction(default) * factor
        if parameter.at_most is not None:
            value = min(value, Fraction(str(parameter.at_most)))
        given[parameter.name] = str(value)
    return case.at(**(given | BRIEF.get(case.id, {})))


def denied(case, instance, shift=Fraction(0)):
    """How many values the witness knows, and those that it denies, of the truth moved by `shift`,
    at three times.
    """
    if isinstance(instance.problem, Motion):
        count = len(instance.times)
        chosen = [instance.times[number] for number in (1, count // 2, count - 1)]
        times = [Fraction(float(t)) for t in chosen]
    else:
        times = []
    found, _ = rows(instance.truth().refined(40), times)
    moved = [(t, name, str(Fraction(mid) + shift), *rest) for t, name, mid, *rest in found]
    said = cross_check.cross_checked(case.id, case.meant(instance.p), moved)
    assert said is not None
    return said["values"], said["denied"]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", OTHERS)
def test_a_case_without_mpmaths_values_meets_its_witness_at_parameters_drawn(name, seed):
    case = discovery.case(name)
    instance = drawn(case, seed)
    values, wrong = denied(case, instance)
    assert values > 0
    assert wrong == []


@pytest.mark.parametrize("name", ["pendulum", *OTHERS])
def test_a_witness_denies_what_is_off_in_its_twentieth_digit(name):
    case = discovery.case(name)
    instance = case.at(**BRIEF.get(case.id, {}))
    values, wrong = denied(case, instance, Fraction(1, 10**20))
    assert len(wrong) == values


def test_a_value_that_is_off_in_its_fortieth_digit_is_a_miss():
    (name, given), asked = next(iter(QUESTIONS.items()))
    wrong = {
        t: {quantity: value + Fraction(1, 10**40) for quantity, value in values.items()}
        for t, values in asked.items()
    }
    truth = discovery.case(name).at(**json.loads(given)).truth().refined(44)
    assert len(misses(truth, wrong)) == sum(map(len, asked.values()))
