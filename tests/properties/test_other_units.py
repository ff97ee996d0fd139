"""A truth does not depend on the units: numbers in other units of mass, length and time have values
that are multiplied by the powers that their units say, and an S that is the same.

REFDEM_RANDOM_SETTINGS (20 for a night) says how many settings a case gets, REFDEM_RANDOM_SEED which
ones.
"""

import os
import random
from fractions import Fraction

import pytest

from refdem.core import discovery
from refdem.core.parameters import Exact
from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError, UsageError
from refdem.truth.closed_forms.spinning_spheres import SpinningSpheres
from refdem.truth.validated_flow import ValidatedFlow
from tests.random_settings import ITERATES, NAMES, SHORT, settings, written
from tests.rationals import text
from tests.units import Change
from tests.units_of_cases import (
    HIDDEN,
    OF_FIXED_SIZE,
    WITHOUT_UNITS,
    hidden,
    unit_of,
    units_of,
)

SETTINGS = int(os.environ.get("REFDEM_RANDOM_SETTINGS", "1"))
SEED = os.environ.get("REFDEM_RANDOM_SEED", "12")
TRIES = 40
"""Draws for one setting: some are refused, for parameters that do not go together."""
DIGITS = 15
BASES = (2, 3, 10)
LARGEST_POWER = 4
LATE = (Fraction(1, 64), Fraction(1, 2))
"""Parts of its default duration at which a motion is asked for."""
SPREAD = Fraction(8, 7) * Fraction(9, 8)
"""S is a bound, at most 1/(1 - 1/8) of what it bounds, of which rounding may be another eighth: two
bounds of the same growth differ by no more.
"""


def drawn_change(rng: random.Random, case: str, given: dict[str, str]) -> Change:
    """Other units, in which the hidden numbers stay what they are; roots of lengths are exact."""
    base = rng.choice(BASES)
    sizes = range(-LARGEST_POWER, LARGEST_POWER + 1)
    changes = [
        Change(base, mass, 2 * length, time) for mass in sizes for length in sizes for time in sizes
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


def asked_at(instance, truth) -> tuple[Fraction, ...]:
    """Exact times at which both are compared."""
    if instance.problem.kind == "iteration":
        return ITERATES
    if "duration" not in instance.p:
        return ()
    duration = Fraction(instance.scales.duration)
    if isinstance(truth, ValidatedFlow):
        duration *= SHORT
    return tuple(duration * part for part in LATE)


def balls_of(truth, t: Fraction | None) -> dict[str, Ball]:
    """The values at t, or the scalars; none where they are not certified."""
    try:
        if t is None:
            return dict(truth.scalars())
        return dict(truth.at(t))
    except NotCertifiedError:
        return {}


def growth_of(truth, t: Fraction) -> float | None:
    """S(t), None where it is not certified."""
    try:
        return truth.sensitivity(t)
    except NotCertifiedError:
        return None


class Pair:
    """One question in two systems of units, and what their answers do not have in common."""

    def __init__(self, case: str, given: dict[str, str], change: Change) -> None:
        self.change = change
        self.one = discovery.case(case).at(**given)
        self.other = discovery.case(case).at(**in_other_units(case, given, change))
        self.truths = (self.one.truth().refined(DIGITS), self.other.truth().refined(DIGITS))
        self.compared = 0
        self.violations: list[str] = []

    def violated(self, what: str, mine: object, theirs: object) -> None:
        """Notes two answers that do not agree."""
        self.violations.append(
            f"{self.one.label} and {self.other.label}: {what} is {mine}, in other units {theirs}"
        )

    def times(self) -> list[tuple[Fraction, Fraction]]:
        """Times in the one and the other units."""
        factor = self.change.factor("s")
        if self.one.problem.kind == "iteration":
            factor = Fraction(1)
        return [(t, t * factor) for t in asked_at(self.one, self.truths[0])]

    def compare_values(self, t: Fraction | None, other_t: Fraction | None) -> None:
        """Values at a time, or scalars."""
        mine = balls_of(self.truths[0], t)
        theirs = balls_of(self.truths[1], other_t)
        if mine.keys() != theirs.keys():
            self.violated(f"what is certified at {t}", sorted(mine), sorted(theirs))
        names = [n for n in mine.keys() & theirs.keys() if not n.startswith(OF_FIXED_SIZE)]
        self.compared += len(names)
        for name in names:
            factor = self.change.factor(unit_of(self.one, name))
            ball = Ball(mine[name].mid * factor, mine[name].radius * factor)
            if abs(ball.mid - theirs[name].mid) > ball.radius + theirs[name].radius:
                self.violated(f"{name} at {t}", float(ball.mid), float(theirs[name].mid))

    def compare_growth(self, t: Fraction, other_t: Fraction) -> None:
        """S at a time."""
        mine = growth_of(self.truths[0], t)
        theirs = growth_of(self.truths[1], other_t)
        if mine is None or theirs is None:
            return
        if max(mine, theirs) > SPREAD * Fraction(min(mine, theirs)):
            self.violated(f"S at {t}", mine, theirs)

    def compare_scales(self) -> None:
        """The scales in which S is measured."""
        for name, quantity in self.one.quantities.items():
            mine = quantity.scale * float(self.change.factor(quantity.unit))
            theirs = self.other.quantities[name].scale
            if not name.startswith(OF_FIXED_SIZE) and abs(mine - theirs) > 1e-12 * theirs:
                self.violated(f"the scale of {name}", mine, theirs)

    def compare(self) -> None:
        """All of it."""
        self.compare_scales()
        for t, other_t in self.times():
            self.compare_values(t, other_t)
            self.compare_growth(t, other_t)
        # Scalars of a contact out of its plane take a minute.
        if not isinstance(self.truths[0], SpinningSpheres):
            self.compare_values(None, None)


def random_pair(case: str, number: int) -> Pair:
    """A case at the first setting of its sequence that is not refused, in two systems of units."""
    rng = random.Random(f"{SEED} {case} {number}")
    for _ in range(TRIES):
        given = settings(rng, case)
        # The default 3/2 has exact powers of lengths.
        given.pop("exponent", None)
        given = written(case, given)
        try:
            return Pair(case, given, drawn_change(rng, case, given))
        except UsageError:
            continue
    raise AssertionError(f"{case}: no setting of {TRIES} was accepted")


def test_cases_without_units_are_cases():
    assert set(WITHOUT_UNITS) < set(NAMES)
    assert set(HIDDEN) < set(NAMES)


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize("case", sorted(set(NAMES) - set(WITHOUT_UNITS)))
def test_truth_is_the_same_in_other_units(case, number):
    pair = random_pair(case, number)
    pair.compare()
    assert pair.compared
    assert pair.violations == []


def test_a_unit_that_is_wrong_is_found():
    """The test of the test: a pendulum whose length alone is changed."""
    pair = random_pair("pendulum", 0)
    pair.change = Change(2, 0, 0, 1)
    pair.compare()
    assert len(pair.violations) > 4
