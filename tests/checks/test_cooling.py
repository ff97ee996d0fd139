"""The check of a cooling gas holds for right gases and kills wrong ones."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.problem import Request
from refdem.core.trajectory import Cost
from refdem.engines.reference import ENGINE
from refdem.faults.change import of_elements, scaled
from refdem.faults.fault import Carrier, Fault
from refdem.mechanics import gas
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.truth.sampled import sampled

CHECK = discovery.check("cooling")
LARGE = {"n": "4000", "duration": "16", "restitution": "4/5", "samples": "8"}
RIGID = {**LARGE, "contact": "rigid"}
METHODS = {"soft": "gas", "rigid": "impacts"}
"""The reference's method for a gas by the kind of its contacts."""


def slimmer(request: Request) -> Request:
    """Spheres of 95 % of their diameter: some contacts are missed."""
    scene = request.problem.scene
    shape = tuple(Sphere(radius=0.95 * s.radius) for s in scene.bodies.shape)
    return request.with_scene(Scene(replace(scene.bodies, shape=shape), scene.elements))


def fault(name: str, before) -> Fault:
    return Fault(
        name=name,
        kind="gas",
        sentence="A wrong gas.",
        on=(),
        sees=("cooling", "temperature"),
        before=before,
    )


FAULTS = {
    "restitution": (
        fault("restitution", of_elements(Contact, damping=scaled(1.2))),
        {"temperature", "loss"},
    ),
    "restitution of impacts": (
        fault("restitution of impacts", of_elements(Contact, restitution=scaled(1.1))),
        {"temperature", "loss"},
    ),
    "missed contacts": (fault("missed", slimmer), {"collisions"}),
    "box": (fault("box", of_elements(PeriodicBox, size=scaled(1.05))), {"collisions"}),
}


@cache
def findings(engine_fault: str = "", **given: str):
    """What the check finds of the reference, or of the reference with a fault."""
    instance = discovery.case("granular-gas").at(**given)
    step = instance.motion.interval / np.ceil(instance.motion.interval / (instance.scales.tau / 5))
    method = ENGINE.method(METHODS[instance.p.contact])
    subject = Subject(instance, method, (step,), sampled(instance.truth(), instance.times.tolist()))
    if (reason := CHECK.applies(subject)) is not None:
        return reason
    if engine_fault:
        engine = Carrier(ENGINE, FAULTS[engine_fault][0])
    else:
        engine = ENGINE
    run, _ = engine.run(Request(problem=instance.motion, method=method.name, step=step))
    return {
        f.quantity: f
        for f in CHECK.judge(subject, {subject.finest: CompletedRun(run, Cost(seconds=0.0))})
    }


@pytest.mark.parametrize("contact", METHODS)
@pytest.mark.parametrize("seed", ["1", "2", "3"])
def test_a_right_gas_passes(seed, contact):
    found = findings(**LARGE, seed=seed, contact=contact)
    assert set(found) == {"temperature", "collisions", "loss"}
    assert {f.outcome for f in found.values()} == {"pass"}
    assert max(f.bound for f in found.values()) < 0.1


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("restitution", LARGE),
        ("restitution of impacts", RIGID),
        ("missed contacts", LARGE),
        ("missed contacts", RIGID),
        ("box", LARGE),
        ("box", RIGID),
    ],
)
def test_a_wrong_gas_fails_where_it_should(name, given):
    found = findings(name, **given)
    assert FAULTS[name][1] <= {quantity for quantity, f in found.items() if f.outcome == "fail"}


@pytest.mark.parametrize("contact", METHODS)
def test_an_elastic_gas_keeps_its_temperature_and_maxwells_velocities(contact):
    found = findings(n="1000", restitution="1", duration="8", contact=contact)
    assert {name: f.outcome for name, f in found.items()} == {
        "temperature": "pass",
        "kurtosis": "pass",
        "collisions": "pass",
    }


def test_an_elastic_gas_of_rigid_spheres_keeps_its_temperature_to_round_off():
    found = findings(n="1000", restitution="1", duration="8", contact="rigid")
    assert found["temperature"].bound < 1e-12
    assert found["temperature"].value < found["temperature"].bound / 10


def test_velocities_that_are_not_maxwells_are_seen():
    velocity = np.random.default_rng(5).uniform(-1, 1, (1000, 3))
    assert abs(gas.velocity_kurtosis(velocity)) > 4 * gas.kurtosis_error(1000) + 0.05


@pytest.mark.parametrize(
    ("given", "why"), [({"density": "1/4"}, "dilute"), ({"restitution": "1/4"}, "restitution")]
)
def test_nothing_is_judged_where_the_theory_does_not_hold(given, why):
    found = findings(n="30", duration="2", **given)
    assert found["temperature"].outcome == "undecided"
    assert why in found["temperature"].sentence


def test_a_gas_is_dilute_up_to_a_tenth_of_the_volume_of_its_box():
    """Spheres of 1 m take pi/6 of a cubic metre each, so that 0.19098 in a cubic metre fill 0.1."""
    above = findings(n="30", duration="2", density="0.1915")["temperature"]
    below = findings(n="30", duration="2", density="0.1905")["temperature"]
    assert "dilute" in above.sentence
    assert "dilute" not in below.sentence


def test_collisions_that_are_not_over_at_the_end_have_not_lost_all_yet():
    found = findings(n="20000", duration="1/16", samples="2")
    assert found["loss"].value > 0.1
    assert (
        found.pop("temperature").outcome == "undecided"
    )  # it falls by less than ten standard errors in so short a time
    assert {f.outcome for f in found.values()} == {"pass"}


def test_it_leaves_out_walls():
    assert "periodic" in findings(n="30", boundary="walls")


@pytest.mark.parametrize(
    ("check", "more"), [("cooling", {}), ("roughness", {"friction": "1000", "restitution": "1"})]
)
@pytest.mark.parametrize("odd", ["mass", "radius"])
def test_a_gas_of_unequal_spheres_is_left_out(check, more, odd):
    scene = discovery.case("granular-gas").at(n="30", **more).scene
    bodies = scene.bodies
    if odd == "mass":
        mixed = replace(bodies, mass=bodies.mass * np.where(np.arange(30) == 29, 2.0, 1.0))
    else:
        mixed = replace(bodies, shape=(*bodies.shape[:-1], Sphere(radius=0.25)))

    def reason(gas):
        instance = SimpleNamespace(scene=gas, quantities={"temperature"})
        return discovery.check(check).applies(SimpleNamespace(instance=instance))

    assert reason(scene) is None
    assert "differ" in reason(Scene(mixed, scene.elements))


def test_collisions_of_a_gas_that_follows_haffs_law_are_the_logarithm_of_time():
    """Integral of w/(1 + t/tau) = w tau ln(1 + t/tau), however few samples there are."""
    t = np.array([0.0, 1.0, 7.0])
    law = gas.haff_temperature(t, 2.0, 3.0)
    expected = 0.5 * 9 * 0.25 * np.sqrt(2.0) * 3.0 * np.log(1 + t / 3.0)
    assert gas.collisions(t, law, 0.25, 10) == pytest.approx(expected, rel=1e-13)
