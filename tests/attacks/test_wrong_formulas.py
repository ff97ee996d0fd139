"""One wrong formula a row of the catalogue, planted in the reference: `error` fails in the quantity
that it spoils.
"""

from functools import cache
from math import pi

import pytest

from refdem.cases.impact_benchmarks import MEMBERS
from refdem.core import discovery
from refdem.core.parameters import labelled
from refdem.engines.reference import ENGINE
from refdem.faults.change import of_bodies, of_elements, scaled
from refdem.faults.fault import Fault
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.moving_anchor import MovingAnchor
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.uniform_gravity import UniformGravity


@cache
def asked(label):
    """An instance, the cheapest method of the reference, and truth; the method is right about
    it.
    """
    case, given = labelled(label)
    instance = discovery.case(case).at(**given)
    method = ENGINE.best(instance.problem).name
    truth = truth_of(instance)
    assert {
        f.outcome
        for f in record_of(task_of(ENGINE, method, instance, truth, 1, ("error",))).findings
    } == {"pass"}
    return instance, method, truth


def failing(label, before):
    """Quantities of which `error` fails when the method is asked something else than it is judged
    for.
    """
    instance, method, truth = asked(label)
    spoiled = Fault(
        name="planted", kind="formula", sentence="", on=(), sees=("error", ""), before=before
    ).carrier(ENGINE)
    findings = record_of(task_of(spoiled, method, instance, truth, 1, ("error",))).findings
    return {f.quantity for f in findings if f.outcome == "fail"}


ROWS = {
    "a moment of inertia in the place of another": (
        "free-rigid-body",
        of_bodies(inertia=lambda j: j[:, [1, 0, 2]]),
        "omega_body.z",
    ),
    "a flip of the other sign": (
        "intermediate-axis",
        of_bodies(inertia=lambda j: j[:, ::-1]),
        "omega_body.x",
    ),
    "the moments of a cluster of equal masses": (
        "rigid-cluster",
        of_bodies(mass=lambda m: 0 * m + m.mean()),
        "r1.x",
    ),
    "one mass off by a billionth": (
        "rigid-cluster",
        of_bodies(mass=lambda m: m * [1 + 1e-9, 1, 1, 1]),
        "r2.y",
    ),
    "a rod that pulls with half of the weight": (
        "pendulum",
        of_elements(UniformGravity, g=scaled(0.5)),
        "theta",
    ),
    "a wheel without inertia": (
        "pendulum-wheel-mass[duration=3 samples=24]",
        of_elements(StringOverWheel, inertia=scaled(0.0)),
        "rdot",
    ),
    "a pivot that shakes a little faster": (
        "kapitza-pendulum[duration=3 samples=24]",
        of_elements(MovingAnchor, frequency=scaled(1 + 1e-9)),
        "theta",
    ),
    "a standing pendulum without weight": (
        "kapitza-pendulum[duration=3 samples=24]",
        of_elements(UniformGravity, g=scaled(0.0)),
        "thetadot",
    ),
    "damping delta in place of 2 delta": (
        "driven-duffing[duration=3 samples=24]",
        of_elements(Dashpot, damping=scaled(0.5)),
        "v",
    ),
    "the cube with the 3/4 of harmonic balance": (
        "driven-duffing[duration=3 samples=24]",
        of_elements(Spring, cubic=scaled(0.75)),
        "x",
    ),
    "a drive that is a sine": (
        "driven-oscillator[duration=3 samples=24]",
        of_elements(Force, phase=lambda phase: phase - pi / 2),
        "x",
    ),
    "a power law with the other root": (
        "power-oscillator[exponent=3/2]",
        of_elements(Spring, stiffness=scaled(1.25)),
        "x",
    ),
    "a square of the other sign": (
        "quadratic-response[duration=3 samples=24]",
        of_elements(Spring, quadratic=scaled(-1.0)),
        "x",
    ),
    "a cycle of twice the nonlinearity": (
        "van-der-pol[duration=3 samples=24]",
        of_elements(Dashpot, van_der_pol=scaled(2.0)),
        "x",
    ),
    "Hertz's law with a third of the stiffness": (
        "hertz-spheres",
        of_elements(Contact, stiffness=scaled(1 / 3)),
        "overlap",
    ),
}


@pytest.mark.parametrize("formula", ROWS)
def test_a_wrong_formula_is_seen_in_what_it_spoils(formula):
    label, before, quantity = ROWS[formula]
    assert quantity in failing(label, before)


@pytest.mark.parametrize("member", MEMBERS)
def test_a_stiffness_off_by_a_millionth_is_seen_in_every_impact(member):
    assert failing(f"impact-benchmarks[{member}]", of_elements(Contact, stiffness=scaled(1 + 1e-6)))


LAWS = [
    ("co-4", {"cutoff": lambda end: "zero_overlap"}, "v.x"),
    ("co-4", {"tangential_stiffness": scaled(2 / 7)}, "omega.z"),
    ("co-4", {"friction": scaled(0.5)}, "omega.z"),
    ("co-3", {"damping": scaled(0.5)}, "v.x"),
    ("co-8", {"branch": lambda arm: "R-d/2"}, "omega1.z"),
    ("dem-02", {"damping": scaled(2.0)}, "r.y"),
    ("dem-05", {"branch": lambda arm: "R-d"}, "omega.z"),
    ("dem-05-mindlin", {"friction": scaled(1.01)}, "omega.z"),
    ("three-spheres", {"branch": lambda arm: "R"}, "omega3.z"),
]


@pytest.mark.parametrize(
    ("member", "change", "quantity"),
    LAWS,
    ids=lambda value: "-".join(value) if isinstance(value, dict) else value,
)
def test_another_law_than_the_one_declared_is_seen(member, change, quantity):
    assert quantity in failing(f"impact-benchmarks[{member}]", of_elements(Contact, **change))
