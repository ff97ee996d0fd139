"""Impulses between samples are those of the law at any step for correct codes; a limit that is
late, or a wrong law, is outside.
"""

from dataclasses import replace
from functools import cache

import pytest

from refdem.core import discovery
from refdem.faults.catalogue import chosen
from refdem.faults.change import of_elements, scaled
from refdem.faults.fault import Fault
from refdem.faults.transparent import Transparent
from refdem.planning import plan
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.planning.specification import Specification
from refdem.scene.elements.contact import Contact
from tests.right_spheres import RightSpheres

SCRAPE = {
    "damping": "1/2",
    "friction": "1/12",
    "angle": "1",
    "masses": "1,2",
    "radii": "1/2,5/8",
    "spins": "0,0,1/8,0,0,-1/16",
}
PUSHES = SCRAPE | {"cutoff": "zero_force"}
IN_SPACE = SCRAPE | {"damping": "0", "spins": "1,0,1/2,0,-2,1"}
REMEMBERS = SCRAPE | {"tangential_stiffness": "64", "damping": "0"}
KNOCK = {"damping": "3", "masses": "1,2"}
FIRST = {"contact": 1, "friction": 1}


class OfFirstOrder(Transparent):
    """The transparent engine with a claim of first order where forces jump, and so with wide bounds
    on its errors.
    """

    methods = tuple(
        replace(method, order_with=FIRST, locates_events=False) for method in Transparent.methods
    )


@cache
def asked(case, given):
    """An instance and its certified samples, proved once."""
    instance = discovery.case(case).at(**dict(given))
    return instance, truth_of(instance)


def found(engine, method, given, case="two-spheres"):
    """The findings of the check alone, by quantity."""
    instance, truth = asked(case, tuple(given.items()))
    task = task_of(engine, method, instance, truth, 3, ("contact-impulse",))
    return {
        finding.quantity: finding
        for finding in record_of(task).findings
        if finding.check == "contact-impulse"
    }


SETTINGS = {
    "scrape": SCRAPE,
    "pushes": PUSHES,
    "in space": IN_SPACE,
    "remembers": REMEMBERS,
    "knock": KNOCK,
}


@pytest.mark.parametrize("name", SETTINGS)
@pytest.mark.parametrize("method", ["verlet", "verlet-single"])
@pytest.mark.parametrize("engine", [Transparent(), OfFirstOrder()], ids=["second", "first"])
def test_impulses_of_a_correct_code_are_those_of_the_law_at_the_coarsest_step(name, method, engine):
    seen = found(engine, method, SETTINGS[name])
    assert {quantity: f.sentence for quantity, f in seen.items() if f.outcome != "pass"} == {}
    slides = name in ("scrape", "pushes", "in space")
    assert set(seen) == ({"normal", "cone"} if slides else {"normal"})


@pytest.mark.parametrize(
    ("case", "given"), [("two-spheres", SCRAPE), ("two-spheres", REMEMBERS), ("hertz-spheres", {})]
)
def test_every_method_of_the_reference_that_steps_holds_it(case, given):
    engine = discovery.engine("reference")
    instance = discovery.case(case).at(**given)
    able = [
        m.name
        for m in engine.methods
        if m.control == "step" and engine.unsupported(instance.problem, m) is None
    ]
    assert able
    for method in able:
        assert {f.outcome for f in found(engine, method, given, case).values()} == {"pass"}, method


def fault(**changes):
    """A fault that changes fields of the contact law."""
    return Fault(
        name="changed",
        kind="contact",
        sentence="",
        on=("scrape",),
        sees=("contact-impulse", "cone"),
        before=of_elements(Contact, **changes),
    )


LATE, WITHOUT = chosen(["contact-limit-late", "contact-limit-without-damping"])


@pytest.mark.parametrize("planted", [fault(friction=scaled(1.05)), LATE], ids=["larger", "late"])
def test_a_limit_of_friction_that_is_too_large_or_late_is_outside_the_cone_at_the_coarsest_step(
    planted,
):
    cone = found(planted.carrier(), "verlet", SCRAPE)["cone"]
    assert cone.outcome == "fail", cone.sentence


@pytest.mark.parametrize(
    "planted",
    [
        fault(cutoff=lambda _: "zero_force"),
        fault(damping=scaled(0.5)),
        fault(stiffness=scaled(1.25)),
    ],
    ids=["tail cut", "damping halved", "stiffer"],
)
def test_a_law_that_is_wrong_within_the_bound_of_first_order_is_seen_at_the_coarsest_step(planted):
    normal = found(planted.carrier(OfFirstOrder()), "verlet", KNOCK)["normal"]
    assert normal.outcome == "fail", normal.sentence


WALLS = {
    "damped": {"member": "co-4", "tangential_stiffness": "0", "angle": "1"},
    "spinning": {"member": "co-6", "tangential_stiffness": "0"},
    "shorter lever": {
        "member": "co-6",
        "tangential_stiffness": "0",
        "spin": "-30",
        "branch": "R-d",
        "cutoff": "zero_overlap",
    },
    "hertz": {"member": "dem-05-hertz", "angle": "1.2"},
}
"""A sphere that slides along a wall."""


@pytest.mark.parametrize("name", WALLS)
@pytest.mark.parametrize(
    ("engine", "method"),
    [
        (Transparent(), "verlet"),
        (Transparent(), "verlet-single"),
        (discovery.engine("reference"), "velocity-verlet"),
        (discovery.engine("reference"), "rk4"),
    ],
)
def test_friction_of_a_correct_code_along_a_wall_is_mu_times_the_normal_force_to_round_off(
    name, engine, method
):
    seen = found(engine, method, WALLS[name], "impact-benchmarks")
    assert {quantity: f.outcome for quantity, f in seen.items()} == dict.fromkeys(
        ("normal", "cone", "sliding"), "pass"
    )


@pytest.mark.parametrize("factor", [1 + 1e-6, 1 - 1e-6])
@pytest.mark.parametrize("name", WALLS)
def test_friction_that_is_off_by_a_millionth_is_seen_along_a_wall(name, factor):
    planted = fault(friction=scaled(factor))
    seen = found(planted.carrier(OfFirstOrder()), "verlet", WALLS[name], "impact-benchmarks")
    assert seen["sliding"].outcome == "fail", seen["sliding"].sentence
    assert seen["sliding"].value > 100 * seen["sliding"].bound


def test_a_sphere_that_sticks_or_keeps_a_spring_is_not_held_to_sliding():
    sprung = found(Transparent(), "verlet", {"member": "co-4"}, "impact-benchmarks")
    assert set(sprung) == {"normal"}
    engine = discovery.engine("reference")
    comes_to_roll = {"member": "dem-05-hertz", "friction": "0.5"}
    rolling = found(engine, "velocity-verlet", comes_to_roll, "impact-benchmarks")
    assert {f.outcome for f in rolling.values()} == {"pass"}


def test_it_does_not_apply_where_something_else_acts_nor_without_steps():
    assert found(discovery.engine("reference"), "exact-harmonic", {}, "harmonic-oscillator") == {}


RIGHT = RightSpheres()
SPREAD: dict[str, tuple[str, dict[str, str]]] = {
    "stiff": ("two-spheres", {"damping": "1", "stiffness": "16"}),
    "stiff, light": ("two-spheres", {"damping": "1", "stiffness": "8"}),
    "damped": ("two-spheres", {"damping": "4"}),
    "unequal": ("two-spheres", {"damping": "1/2", "masses": "1,2"}),
    "overdamped": ("two-spheres", {"damping": "32", "cutoff": "zero_force"}),
    "scrape": ("two-spheres", SCRAPE),
    "reverses": (
        "two-spheres",
        SCRAPE | {"friction": "1/2", "angle": "1/4", "damping": "1", "branch": "R"},
    ),
    "far apart masses": ("two-spheres", SCRAPE | {"masses": "1/8,16", "cutoff": "zero_force"}),
    "comes to roll": (
        "impact-benchmarks",
        {"member": "dem-05-hertz", "angle": "0.3", "friction": "1/2"},
    ),
    "damped wall": ("impact-benchmarks", WALLS["damped"]),
    "spinning": ("impact-benchmarks", WALLS["spinning"]),
}
"""Settings over which the check once accused right programs, and others like them."""


@pytest.mark.parametrize("name", SPREAD)
@pytest.mark.parametrize("method", [method.name for method in RIGHT.methods])
def test_no_state_that_a_right_scheme_puts_into_the_law_is_accused(name, method):
    case, given = SPREAD[name]
    instance = discovery.case(case).at(**given)
    specification = Specification(
        name="right", case=[], levels=3, method=method, checks=["contact-impulse"], most_steps=2e4
    )
    # The check needs no truth.
    (task,) = plan.tasks(specification, instance, (), RIGHT, None, "it is not asked for")
    record = record_of(task)
    sentences = {f.quantity: f.sentence for f in record.findings if f.outcome != "pass"}
    assert sentences == {}
    assert any(finding.quantity == "normal" for finding in record.findings)
