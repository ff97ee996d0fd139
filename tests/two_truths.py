"""Two questions whose answers differ by known factors alone: what their truths do not have in
common.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction

from refdem.core.case import Instance
from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.closed_forms.spinning_spheres import SpinningSpheres
from refdem.truth.validated_flow import ValidatedFlow
from tests.random_settings import ITERATES, SHORT

DIGITS = 15
LATE = (Fraction(1, 64), Fraction(1, 2))
"""Parts of its default duration at which a motion is asked for."""
SPREAD = Fraction(8, 7) * Fraction(9, 8)
"""S is a bound, at most 1/(1 - 1/8) of what it bounds, of which rounding may be another eighth: two
bounds of the same growth differ by no more.
"""
Answer = tuple[str, Fraction]
"""The name of a value in the other truth, and that value divided by this one."""


def asked_at(instance: Instance, truth: Truth) -> tuple[Fraction, ...]:
    """Exact times at which both are compared."""
    if instance.problem.kind == "iteration":
        return ITERATES
    if "duration" not in instance.p:
        return ()
    duration = Fraction(instance.scales.duration)
    if isinstance(truth, ValidatedFlow):
        duration *= SHORT
    return tuple(duration * part for part in LATE)


def balls_at(truth: Truth, t: Fraction | None) -> Mapping[str, Ball]:
    """The values at t, or the scalars; none where they are not certified."""
    try:
        if t is None:
            return truth.scalars()
        return truth.at(t)
    except NotCertifiedError:
        return {}


def growth_at(truth: Truth, t: Fraction) -> float | None:
    """S(t), None where it is not certified."""
    try:
        return truth.sensitivity(t)
    except NotCertifiedError:
        return None


class TwoTruths:
    """The truths of two instances; `answers` gives the other name and the factor of a value, None
    where that has no counterpart, and time is `slower` times as long in the other.
    """

    def __init__(
        self,
        one: Instance,
        other: Instance,
        answers: Callable[[str], Answer | None],
        slower: Fraction = Fraction(1),
    ) -> None:
        self.instances = (one, other)
        self.truths = (one.truth().refined(DIGITS), other.truth().refined(DIGITS))
        self.answers = answers
        self.slower = slower
        self.compared = 0
        self.differences: list[str] = []

    def differ(self, what: str, mine: object, theirs: object) -> None:
        """Notes two answers that have nothing in common."""
        one, other = (instance.label for instance in self.instances)
        self.differences.append(f"{one} and {other}: {what} is {mine}, and {theirs} in the other")

    def counterparts(self, mine: Mapping[str, object]) -> dict[str, Answer]:
        """The names that are compared, each with that of the other truth and the factor."""
        found = {name: self.answers(name) for name in mine}
        return {name: answer for name, answer in found.items() if answer is not None}

    def compare_values(self, t: Fraction | None) -> None:
        """Values at a time, or scalars."""
        mine = balls_at(self.truths[0], t)
        theirs = balls_at(self.truths[1], t and t * self.slower)
        if len(mine) != len(theirs):
            self.differ(f"what is certified at {t}", sorted(mine), sorted(theirs))
            return
        for name, (other_name, factor) in self.counterparts(mine).items():
            expected = mine[name].mid * factor
            found = theirs[other_name]
            self.compared += 1
            if abs(expected - found.mid) > mine[name].radius * abs(factor) + found.radius:
                self.differ(f"{name} at {t}", float(expected), float(found.mid))

    def compare_growth(self, t: Fraction) -> None:
        """S at a time."""
        mine = growth_at(self.truths[0], t)
        theirs = growth_at(self.truths[1], t * self.slower)
        if mine is None or theirs is None:
            return
        if max(mine, theirs) > SPREAD * Fraction(min(mine, theirs)):
            self.differ(f"S at {t}", mine, theirs)

    def compare_scales(self) -> None:
        """The scales in which S is measured."""
        one, other = (instance.quantities for instance in self.instances)
        for name, (other_name, factor) in self.counterparts(one).items():
            expected = one[name].scale * abs(float(factor))
            found = other[other_name].scale
            if abs(expected - found) > 1e-12 * found:
                self.differ(f"the scale of {name}", expected, found)

    def compare(self) -> None:
        """Everything that both say."""
        self.compare_scales()
        for t in asked_at(self.instances[0], self.truths[0]):
            self.compare_values(t)
            self.compare_growth(t)
        # Scalars of a contact out of its plane take a minute.
        if not isinstance(self.truths[0], SpinningSpheres):
            self.compare_values(None)
