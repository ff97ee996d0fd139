"""A gate that names no case runs also what the defaults of a case keep still."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.faults.catalogue import chosen
from refdem.faults.change import of_bodies, of_elements
from refdem.faults.fault import Carrier, Fault
from refdem.faults.transparent import Transparent
from refdem.gate.gate import supported
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.planning.specification import named
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

TELLING = named("gate").case
TWO_SPHERES = [{}, *(entry.set for entry in TELLING if entry.id == "two-spheres")]


@pytest.mark.parametrize("entry", TELLING, ids=lambda entry: entry.label)
def test_every_setting_is_one_that_a_case_knows_and_is_certified_to_the_end(entry):
    instance = discovery.case(entry.id).at(**entry.set)
    # What is dear to prove is kept, and proved again where it is stale.
    truth = truth_of(instance)
    assert truth.until == len(truth.t) == len(instance.times)
    assert truth.t == instance.times.tolist()
    assert truth.radii
    assert all(radii[-1] < 1e-12 for radii in truth.radii.values())


def test_a_gate_of_all_cases_has_them_beside_the_defaults():
    entries = [entry for entry in supported(ENGINE) if entry.id == "two-spheres"]
    assert [entry.set for entry in entries] == TWO_SPHERES


def contact(**changed):
    """A fault that misreads the contact law of a scene."""
    return of_elements(Contact, **changed)


def at_rest_when_slow(request):
    """What is slower than 1 cm/s is taken to be at rest."""
    change = of_bodies(
        velocity=lambda v: np.where(np.linalg.norm(v, axis=1, keepdims=True) < 0.01, 0.0, v)
    )
    return change(request)


def without_friction_where_nothing_is_damped(request):
    """Friction is left out with the dashpot."""
    (law,) = request.problem.scene.all(Contact)
    if law.damping == 0:
        return contact(friction=lambda mu: 0.0)(request)
    return request


def asked(instance):
    """The request of an instance in one step a sample."""
    return Request(problem=instance.problem, method="verlet", step=instance.problem.interval)


SLOW_AND_SOFT = 7
SLOW = {SLOW_AND_SOFT, 8}
UNDAMPED = {6, SLOW_AND_SOFT, 10}
MISREADINGS = {
    "a tangential spring of at least 1 N/m": (
        contact(tangential_stiffness=lambda k: max(k, 1.0) if k else k),
        {SLOW_AND_SOFT},
    ),
    "slow bodies at rest": (at_rest_when_slow, SLOW),
    "no friction without damping": (without_friction_where_nothing_is_damped, UNDAMPED),
}
"""Faults of the question, and the numbers of the settings of two-spheres on which they act."""


@pytest.mark.parametrize("name", MISREADINGS)
def test_some_faults_act_only_on_the_settings_that_are_there_for_them_and_fail_there(name):
    misread, seen = MISREADINGS[name]
    instances = [discovery.case("two-spheres").at(**given) for given in TWO_SPHERES]
    requests = [asked(instance) for instance in instances]
    frictional = {
        number
        for number in range(len(requests))
        if instances[number].scene.all(Contact)[0].friction > 0
    }
    acts_on = {
        number
        for number in range(len(requests))
        if misread(requests[number]).to_json() != requests[number].to_json()
    }
    assert acts_on & frictional == seen
    fault = Fault(name="misread", kind="misread", sentence="", on=(), sees=("", ""), before=misread)
    instance = instances[SLOW_AND_SOFT]
    truth = truth_of(instance)
    for engine, expected in ((Transparent(), False), (Carrier(Transparent(), fault), True)):
        record = record_of(task_of(engine, "verlet", instance, truth, 5, ["error"]))
        assert any(finding.outcome == "fail" for finding in record.findings) == expected


def without_weight_at_soft_contacts(request):
    """Gravity is left out where bodies have soft contacts."""
    laws = {law.law for law in request.problem.scene.all(Contact)}
    if "linear" not in laws:
        return request
    return of_elements(UniformGravity, g=lambda g: (0.0, 0.0, 0.0))(request)


def with_the_first_wall_alone(request):
    """Walls beyond the first one are left out."""
    scene = request.problem.scene
    later_walls = scene.all(Plane)[1:]
    kept = tuple(element for element in scene.elements if element not in later_walls)
    return request.with_scene(Scene(scene.bodies, kept))


OF_CONTACTS = {
    "no weight at soft contacts": (
        without_weight_at_soft_contacts,
        {"dem-01", "dem-03", "dem-04"},
        "dem-04",
    ),
    "one wall": (with_the_first_wall_alone, {"dem-03"}, "dem-03"),
}
"""Faults of the question, the members of the impact benchmarks on which alone they act, and the one
that is judged.
"""


@pytest.mark.parametrize("name", OF_CONTACTS)
def test_weight_and_walls_at_soft_contacts_are_told_by_the_members_that_are_there_for_them(name):
    misread, members, judged = OF_CONTACTS[name]
    acted = {}
    for entry in supported(ENGINE):
        if entry.id != "impact-benchmarks":
            continue
        instance = discovery.case(entry.id).at(**entry.set)
        request = asked(instance)
        if misread(request).to_json() != request.to_json():
            acted[entry.set["member"]] = instance
    assert set(acted) == members
    fault = Fault(name="misread", kind="misread", sentence="", on=(), sees=("", ""), before=misread)
    instance = acted[judged]
    truth = truth_of(instance)
    for engine, expected in ((Transparent(), False), (Carrier(Transparent(), fault), True)):
        record = record_of(task_of(engine, "verlet", instance, truth, 3, ["error"]))
        assert any(finding.outcome == "fail" for finding in record.findings) == expected


TELLS = {
    "drive-without-phase": ("van-der-pol", 1),
    "square-of-one-sign": ("quadratic-response", 2),
    "small-world": ("harmonic-oscillator", 2),
    "friction-off-by-a-millionth": ("impact-benchmarks", 3),
    "impacts-of-a-pair-once": ("newtons-cradle", 1),
    "bounce-friction-from-weight": ("bouncing-ball", 1),
}
"""By fault of the catalogue: the case, and the number, from 1, of the setting that tells it."""


@pytest.mark.parametrize("name", TELLS)
def test_a_fault_is_seen_at_the_setting_that_is_there_for_it_and_nothing_is_seen_without_it(name):
    (fault,) = chosen([name])
    check, quantity = fault.sees
    case, number = TELLS[name]
    beside = [entry.set for entry in TELLING if entry.id == case]
    instance = discovery.case(case).at(**beside[number - 1])
    truth = truth_of(instance)

    def outcome(engine):
        record = record_of(task_of(engine, "verlet", instance, truth, 4, [check]))
        (finding,) = (f for f in record.findings if (f.check, f.quantity) == (check, quantity))
        return finding.outcome

    assert outcome(Transparent()) == "pass"
    assert outcome(fault.carrier()) == "fail"
