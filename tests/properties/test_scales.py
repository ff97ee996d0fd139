"""A scale belongs to the motion: other samples of it change none."""

import pytest

from refdem.core import discovery
from refdem.core.selection import Selection

SAMPLED = [
    name
    for name in discovery.names("cases")
    if not isinstance(discovery.case(name), Selection)
    and discovery.case(name).at().problem.kind == "motion"
]
LATE = {"bouncing-ball"}
"""Cases whose tau is shorter where a bounce comes soon before a sample that a late one would spoil:
what checks allow beside an impact is not there for a wall that gravity presses on.
"""


def scales_with(name, samples):
    case = discovery.case(name)
    duration = repr(case.at().scales.duration)
    of = case.at(duration=duration, samples=str(samples))
    return of.scales, {name: quantity.scale for name, quantity in of.quantities.items()}


def test_most_cases_are_sampled():
    assert len(SAMPLED) > 30
    assert set(SAMPLED) > LATE


@pytest.mark.parametrize("name", sorted(set(SAMPLED) - LATE))
def test_scales_are_the_same_whatever_the_samples(name):
    assert scales_with(name, 2) == scales_with(name, 64) == scales_with(name, 37)
