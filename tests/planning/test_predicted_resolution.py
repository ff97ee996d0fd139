"""Resolution by certified derivatives agrees with the one that misread runs show."""

import pytest

from refdem.core import discovery
from refdem.core.resolution import NumberResolution, Resolution
from refdem.faults.numbers import numbers
from refdem.planning.in_process import truth_of
from refdem.planning.predicted_resolution import (
    NO_DERIVATIVE,
    NOT_OF_THE_CASE,
    NOT_SMALL,
    SMALL,
    beside,
    numbers_behind,
    predicted,
)
from refdem.planning.resolution import resolution
from refdem.planning.specification import Specification

AGREE = 2.0
"""Factor within which what is predicted and what is planted agree."""
AGAINST_TRUTH = ["error", "limit", "order"]
"""Checks that see nothing but quantities, which are displaced alike in both."""
PLANTED = [
    ("pendulum", "mujoco", "rk4", {}),
    ("pendulum", "pymunk", "semi-implicit-euler", {}),
    ("harmonic-oscillator", "rebound", "leapfrog", {}),
    ("harmonic-oscillator", "mujoco", "implicitfast", {"mass": "3"}),
    ("free-rigid-body", "reference", "splitting-free-body", {"samples": "16"}),
    ("duffing", "rebound", "leapfrog", {}),
    ("coulomb-oscillator", "pymunk", "semi-implicit-euler", {}),
    (
        "hard-spheres",
        "pymunk",
        "semi-implicit-euler",
        {"friction": "1/4", "spins": "0,0,1,0,0,-2", "masses": "1,3", "radii": "1/2,3/4"},
    ),
]
WITHOUT = {
    "exponent of the spring",
    "normal force of the slider",
    "mass of body 0",
    "mass of body 1",
    "velocity of body 0",
    "velocity of body 1",
    "position of body 0",
    "position of body 1",
    "radius of the spheres",
    "mass",
}
"""Numbers of scenes that no number of some of these cases stands for alone."""


@pytest.mark.parametrize(("name", "engine", "method", "given"), PLANTED)
def test_what_is_foreseen_is_what_misread_runs_show(name, engine, method, given):
    instance = discovery.case(name).at(**given)
    code = discovery.engine(engine)
    truth = truth_of(instance)
    specification = Specification(
        name="test", case=[], levels=4, method=method, checks=AGAINST_TRUTH
    )
    planted = {
        entry.number: entry for entry in resolution(specification, code, instance, truth).numbers
    }
    computed = predicted(specification, code, instance, truth)
    assert [entry.number for entry in computed] == list(planted)
    compared = 0
    for entry in computed:
        shown = planted[entry.number].smallest
        if entry.reason == NOT_OF_THE_CASE:
            assert entry.number in WITHOUT
        elif entry.smallest is None:
            assert entry.reason in (NOT_SMALL, NO_DERIVATIVE, "no quantity depends on it")
            assert shown is None or shown > SMALL / AGREE
        else:
            assert shown is not None, entry
            assert shown / AGREE <= entry.smallest <= AGREE * shown, (entry, planted[entry.number])
            compared += 1
    assert compared >= 2


def test_the_numbers_of_a_case_behind_those_of_its_scene():
    instance = discovery.case("pendulum").at()
    found = {
        number.name: [one.name for one in numbers_behind(instance, number)]
        for number in numbers(instance.scene)
    }
    assert found["mass"] == ["mass"]
    assert found["length of the rods"] == ["length"]
    assert found["g of the uniform gravity"] == ["gravity"]


def test_a_number_that_is_no_smaller_than_a_scene_allows_is_still_known():
    """A moment of inertia of 3 is the sum of the others, and no larger one is that of a body."""
    instance = discovery.case("free-rigid-body").at()
    found = {
        number.name: [one.name for one in numbers_behind(instance, number)]
        for number in numbers(instance.scene)
    }
    assert found["moment of inertia 3"] == ["inertia.2"]
    assert len(found["spin"]) == 3


def test_it_stands_beside_what_was_measured():
    entries = (
        NumberResolution(number="mass", smallest=1e-9, by="error/x"),
        NumberResolution(number="exponent of the spring"),
    )
    measured = Resolution(
        label="harmonic-oscillator[mass=2]", engine="rebound", method="leapfrog", numbers=entries
    )
    specification = Specification(name="test", case=[], levels=4)
    mass, exponent = beside(specification, measured).numbers
    assert (mass.smallest, mass.by) == (1e-9, "error/x")
    assert 0 < mass.computed < 1e-6
    assert mass.computed_by
    assert exponent.computed is None
    assert exponent.computed_by == NOT_OF_THE_CASE
