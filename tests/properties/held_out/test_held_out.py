"""Truth at parameters that no certified set has, to 40 digits, against values.txt, which
by_mpmath.py has made: no code is shared.
"""

import json
from collections import defaultdict
from fractions import Fraction
from pathlib import Path

import pytest

from refdem.core import discovery
from refdem.core.selection import Selection
from refdem.truth import load

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


def test_every_case_with_truth_is_asked():
    cases = {
        name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
    }
    assert cases == {name for name, _ in QUESTIONS}


def test_a_value_that_is_off_in_its_fortieth_digit_is_a_miss():
    (name, given), asked = next(iter(QUESTIONS.items()))
    wrong = {
        t: {quantity: value + Fraction(1, 10**40) for quantity, value in values.items()}
        for t, values in asked.items()
    }
    truth = discovery.case(name).at(**json.loads(given)).truth().refined(44)
    assert len(misses(truth, wrong)) == sum(map(len, asked.values()))
