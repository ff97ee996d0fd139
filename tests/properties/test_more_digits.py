"""More digits never contradict fewer: answers to 15, 30 and 60 digits overlap, at every certified
set and at random settings.

An iteration that stops too early, or a number that is rounded at one precision otherwise than at
another, is found here. REFDEM_RANDOM_SETTINGS (20 for a night) says how many settings a case gets,
REFDEM_RANDOM_SEED which ones.
"""

import os
from fractions import Fraction

import pytest

from refdem.certification.reproof import given_of
from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError
from refdem.truth import load
from refdem.truth.closed_forms.spinning_spheres import SpinningSpheres
from tests.random_settings import NAMES, early, first_accepted, settings, shortened

AT_NIGHT = "REFDEM_RANDOM_SETTINGS" in os.environ
SETTINGS = int(os.environ.get("REFDEM_RANDOM_SETTINGS", "2"))
DIGITS = (15, 30, 60)


def random_instance(case: str, number: int):
    """The case at a random setting that has a truth."""

    def made(rng):
        instance = shortened(case, settings(rng, case))
        instance.truth()
        return instance

    return first_accepted(case, number, made)


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
