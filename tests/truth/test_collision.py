"""S of a collision counts errors that are there at touch, which change when the spheres touch."""

import random

import pytest

from tests.attack import Attack
from tests.random_settings import written

TOUCHES = {
    "a dashpot at a wall": {"member": "co-3"},
    "a dashpot and a spring at a wall": {"member": "co-6"},
    "a spring at a wall": {
        "member": "dem-05",
        "material": "magnesium-alloy",
        "friction": "0.22264",
    },
}


def attack_on(name: str) -> Attack:
    """A wall that is touched at t = 0, attacked along every coordinate that S counts."""
    return Attack(
        "impact-benchmarks", written("impact-benchmarks", TOUCHES[name]), random.Random(3)
    )


@pytest.mark.parametrize("name", TOUCHES)
def test_a_place_that_is_off_at_touch_grows_by_no_more_than_s(name):
    assert attack_on(name).violations() == []


@pytest.mark.parametrize("name", TOUCHES)
def test_s_soon_after_touch_is_what_the_attack_finds(name):
    attack = attack_on(name)
    assert attack.bounds[1] < 1.05 * max(attack.growths(1))
