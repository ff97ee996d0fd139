"""S of a collision counts errors that are there at touch: a place that is off changes when the
spheres touch, and a slip that is no more than an error has friction against it.
"""

import random

import pytest

from refdem.truth.growth import WIDEST
from tests.attack import Attack
from tests.random_settings import written

IMPACTS = "impact-benchmarks"
TOUCHES = {
    "a dashpot at a wall": (IMPACTS, {"member": "co-3"}),
    "a dashpot and a spring at a wall": (IMPACTS, {"member": "co-6"}),
    "a spring at a wall": (
        IMPACTS,
        {"member": "dem-05", "material": "magnesium-alloy", "friction": "0.22264"},
    ),
}
RESTS = {
    "spins that roll on each other": (IMPACTS, {"member": "co-7"}),
    "a spring at a wall that rests": (IMPACTS, {"member": "co-6", "spin": "0"}),
    "a wall that rests": (IMPACTS, {"member": "co-6", "spin": "0", "tangential_stiffness": "0"}),
    "a spring": ("two-spheres", {"friction": "0.4", "tangential_stiffness": "20"}),
    "no spring": ("two-spheres", {"friction": "0.4", "closing_speed": "0.886"}),
}
"""Contacts in which nothing slips, but for an error."""
ALL = TOUCHES | RESTS


def attack_on(name: str) -> Attack:
    """A contact from touch on, attacked along every coordinate that S counts."""
    case, given = ALL[name]
    return Attack(case, written(case, given), random.Random(3))


@pytest.mark.parametrize("name", TOUCHES)
def test_a_place_that_is_off_at_touch_grows_by_no_more_than_s(name):
    assert attack_on(name).violations() == []


@pytest.mark.parametrize("name", RESTS)
def test_a_slip_that_an_error_starts_grows_by_no_more_than_s(name):
    assert attack_on(name).violations() == []


@pytest.mark.parametrize("name", ALL)
def test_s_soon_after_touch_is_what_the_attack_finds(name):
    attack = attack_on(name)
    # Cells of times make S at most 1/(1 - WIDEST) of what it bounds.
    assert attack.bounds[1] * (1 - WIDEST) < max(attack.growths(1))
