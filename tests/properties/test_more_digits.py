"""More digits never contradict fewer: answers to 15, 30 and 60 digits overlap, at every certified
set and at random settings.

An iteration that stops too early, or a number that is rounded at one precision otherwise than at
another, is found here. REFDEM_RANDOM_SETTINGS (20 for a night) says how many settings a case gets,
REFDEM_RANDOM_SEED which ones.
"""

import os
import random
from fractions import Fraction

import pytest

from refdem.campaign.reproof import given_of
from refdem.cases.impact_benchmarks import MEMBERS, member
from refdem.core import discovery
from refdem.core.parameters import Parameter
from refdem.core.selection import Selection
from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError, RefdemError
from refdem.truth import load
from refdem.truth.closed_forms.spinning_spheres import SpinningSpheres

AT_NIGHT = "REFDEM_RANDOM_SETTINGS" in os.environ
SETTINGS = int(os.environ.get("REFDEM_RANDOM_SETTINGS", "2"))
SEED = os.environ.get("REFDEM_RANDOM_SEED", "12")
DIGITS = (15, 30, 60)
SHORT = Fraction(1, 16)
"""Part of its default duration that a motion gets: validated integration costs as much as the time
it covers.
"""
EARLY = (Fraction(1, 16), Fraction(1, 4))
"""Parts of that."""
ITERATES = (Fraction(1), Fraction(7))
TRIES = 40
"""Draws for one setting: some are refused, for parameters that do not go together."""
LEFT_ALONE = ("duration", "samples", "points", "n", "spheres", "member")
NAMES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]


def near(rng: random.Random, parameter: Parameter, value: Fraction) -> Fraction:
    """A number within a factor of 3 of a default, or of 1/4 where that is 0; inside the bounds."""
    found = (value or Fraction(1, 4)) * Fraction(rng.randint(300, 3000), 1000)
    if parameter.above is not None:
        low = parameter.above
    else:
        low = parameter.at_least
    if low is None and rng.random() < 0.3:
        found = -found
    if low is not None and found <= Fraction(repr(low)):
        found = abs(found)
    if parameter.at_most is None:
        high = None
    else:
        high = Fraction(repr(parameter.at_most))
    if high is None or found <= high:
        return found
    return high * Fraction(rng.randint(100, 999), 1000)


def drawn(rng: random.Random, parameter: Parameter, default: str) -> str:
    """Another value of a parameter, as text."""
    if parameter.choices:
        return rng.choice(parameter.choices)
    own = Parameter(
        name=parameter.name, default=default, unit="", doc="", shape=parameter.shape
    ).parsed(default)
    if isinstance(own, tuple):
        values = own
    else:
        values = (own,)
    if parameter.whole:
        return default
    return ",".join(str(near(rng, parameter, value)) for value in values)


def settings(rng: random.Random, case: str) -> dict[str, str]:
    """A few parameters of a case, drawn anew."""
    declared = {p.name: p for p in discovery.case(case).parameters}
    given = {}
    defaults = {
        name: p.default for name, p in declared.items() if name not in LEFT_ALONE and p.default
    }
    if case == "impact-benchmarks":
        given["member"] = rng.choice(MEMBERS)
        defaults = dict(member(given["member"]).numbers)
    chosen = rng.sample(sorted(defaults), min(len(defaults), rng.randint(1, 4)))
    return given | {name: drawn(rng, declared[name], defaults[name]) for name in chosen}


def shortened(case: str, given: dict[str, str]):
    """The case at a setting, with a short duration where it has one."""
    instance = discovery.case(case).at(**given)
    if "duration" not in instance.p:
        return instance
    return discovery.case(case).at(
        **{**given, "duration": str(Fraction(instance.scales.duration) * SHORT)}
    )


def random_instance(case: str, number: int):
    """The case at the first setting of its sequence that is not refused."""
    rng = random.Random(f"{SEED} {case} {number}")
    for _ in range(TRIES):
        try:
            instance = shortened(case, settings(rng, case))
            instance.truth()
        except RefdemError:
            continue
        return instance
    raise AssertionError(f"{case}: no setting of {TRIES} was accepted")


def answers(truth, times):
    """Scalars, and the quantities at the times, as far as they are certified."""
    found = {}
    asked = [(t, lambda t=t: truth.at(t)) for t in times]
    # Scalars of a contact out of its plane take a minute: for those there is the night.
    if AT_NIGHT or not isinstance(truth, SpinningSpheres):
        asked.append(("scalars", truth.scalars))
    for when, ask in asked:
        try:
            found |= {(when, name): ball for name, ball in ask().items()}
        except NotCertifiedError:
            continue
    return found


def contradictions(instance, times):
    """What the answers to different digits do not have in common."""
    each = [answers(instance.truth().refined(digits), times) for digits in DIGITS]
    found = []
    for fewer, more in ((0, 1), (0, 2), (1, 2)):
        for key in each[fewer].keys() & each[more].keys():
            one = each[fewer][key]
            other = each[more][key]
            if abs(one.mid - other.mid) > one.radius + other.radius:
                found.append(
                    f"{instance.label}: {key[1]} at {key[0]} with {DIGITS[fewer]} and"
                    f" {DIGITS[more]} digits"
                )
    return found


def early(instance):
    """Two exact times soon after the start."""
    if instance.case.id in ("logistic", "billiards"):
        return ITERATES
    if "duration" not in instance.p:
        return ()
    duration = Fraction(instance.scales.duration)
    return tuple(duration * part for part in EARLY)


@pytest.mark.parametrize("number", range(SETTINGS))
@pytest.mark.parametrize("case", NAMES)
def test_more_digits_agree_with_fewer_at_random_settings(case, number):
    instance = random_instance(case, number)
    assert contradictions(instance, early(instance)) == []


@pytest.mark.parametrize("case", NAMES)
def test_more_digits_agree_with_fewer_at_every_certified_set(case):
    found = []
    for one in load(case):
        instance = shortened(case, given_of(one))
        found += contradictions(instance, early(instance))
    assert found == []


def test_balls_that_are_too_small_for_their_precision_are_found():
    """The test of the test: a third, 3 units off in the last digit that is asked for, with a radius
    of 1.
    """

    class Off:
        def __init__(self, digits=15):
            self.unit = Fraction(1, 10**digits)

        def refined(self, digits):
            return Off(digits)

        def scalars(self):
            return {"third": Ball(Fraction(1, 3) + 3 * self.unit, self.unit)}

    class Of:
        label = "off"

        def truth(self):
            return Off()

    assert len(contradictions(Of(), ())) == 3
