"""A truth does not depend on the units: numbers in other units of mass, length and time have values
that are multiplied by the powers that their units say, and an S that is the same.

REFDEM_RANDOM_SETTINGS (20 for a night) says how many settings a case gets, REFDEM_RANDOM_SEED which
ones.
"""

import itertools
import random
from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.core.parameters import Exact
from tests.random_settings import NAMES, SETTINGS, first_accepted, settings, written
from tests.rationals import text
from tests.two_truths import Answer, TwoTruths
from tests.units import Change
from tests.units_of_cases import (
    HIDDEN,
    OF_FIXED_SIZE,
    WITHOUT_UNITS,
    hidden,
    unit_of,
    units_of,
)

BASES = (2, 3, 10)
LARGEST_POWER = 3
"""Of a base; twice that of masses and lengths."""


def drawn_change(rng: random.Random, case: str, given: dict[str, str]) -> Change:
    """Other units, in which the hidden numbers stay what they are; roots of lengths are exact."""
    base = rng.choice(BASES)
    sizes = range(-LARGEST_POWER, LARGEST_POWER + 1)
    changes = [
        Change(base, 2 * mass, 2 * length, time)
        for mass, length, time in itertools.product(sizes, sizes, sizes)
    ]
    fixed = hidden(case, given)
    changes.remove(Change(base, 0, 0, 0))
    return rng.choice(
        [change for change in changes if all(change.factor(unit) == 1 for unit in fixed)]
    )


def multiplied(value: Exact, unit: str, change: Change, n: Fraction) -> str:
    """The text of a number, or of several, in other units; `unit` is one for all, or has one for
    each, as in `m, m/s`.
    """
    if isinstance(value, tuple):
        numbers = value
    else:
        numbers = (value,)
    factors = [change.factor(each, n) for each in unit.split(", ")]
    if len(factors) != len(numbers):
        factors = factors[:1] * len(numbers)
    return text(number * factor for number, factor in zip(numbers, factors, strict=True))


def in_other_units(case: str, given: dict[str, str], change: Change) -> dict[str, str]:
    """The same setting as numbers in other units."""
    declared = {p.name: p for p in discovery.case(case).parameters}
    n = Fraction(given.get("exponent", "1"))
    units = units_of(case, given)
    other = {}
    for name, words in given.items():
        value = declared[name].parsed(words)
        if isinstance(value, str):
            other[name] = words
        else:
            other[name] = multiplied(value, units[name], change, n)
    return other


def in_two_units(case: str, given: dict[str, str], change: Change) -> TwoTruths:
    """A setting and the same one in other units."""
    one = discovery.case(case).at(**given)
    other = discovery.case(case).at(**in_other_units(case, given, change))

    def answers(name: str) -> Answer | None:
        if name.startswith(OF_FIXED_SIZE):
            return None
        return name, change.factor(unit_of(one, name))

    if one.problem.kind == "iteration":
        return TwoTruths(one, other, answers)
    return TwoTruths(one, other, answers, change.factor("s"))


def random_pair(case: str, number: int) -> TwoTruths:
    """A case at a random setting, in two systems of units."""

    def made(rng: random.Random) -> TwoTruths:
        given = settings(rng, case)
        # The default 3/2 has exact powers of lengths.
        given.pop("exponent", None)
        given = written(case, given)
        return in_two_units(case, given, drawn_change(rng, case, given))

    return first_accepted(case, number, made)


def test_cases_without_units_are_cases():
    assert set(WITHOUT_UNITS) < set(NAMES)
    assert set(HIDDEN) < set(NAMES)


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize("case", sorted(set(NAMES) - set(WITHOUT_UNITS)))
def test_truth_is_the_same_in_other_units(case, number):
    pair = random_pair(case, number)
    pair.compare()
    assert pair.compared
    assert pair.differences == []


def test_a_unit_that_is_wrong_is_found():
    """The test of the test: a pendulum whose length alone is changed."""
    one = discovery.case("pendulum").at()
    other = discovery.case("pendulum").at(length="2")
    pair = TwoTruths(one, other, lambda name: (name, Fraction(1)))
    pair.compare()
    assert len(pair.differences) > 4
