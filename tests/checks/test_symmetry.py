"""The symmetry check passes the reference and is failed, in the symmetry that is broken, by a code
that breaks it.
"""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from refdem.checks.symmetry import Symmetry
from refdem.core import discovery, symmetry
from refdem.core.check import CompletedRun
from refdem.core.engine import Method
from refdem.core.trajectory import Cost, Trajectory
from refdem.faults.change import of_bodies, of_elements, single
from refdem.faults.fault import Fault
from refdem.mechanics.quaternion import product
from refdem.planning import plan
from refdem.planning.in_process import record_of, truth_of
from refdem.planning.specification import Specification
from refdem.scene.elements.spring import Spring
from tests.handmade import all_runs
from tests.right_spheres import RightSpheres

SPECIFICATION = Specification(name="test", case=[], levels=3)
CASES = {
    "two-spheres": {
        "damping": "1",
        "angle": "1/2",
        "friction": "1/4",
        "tangential_stiffness": "96",
        "spins": "0,0,1,0,0,-2",
        "masses": "1,3",
    },
    "free-rigid-body": {},
    "harmonic-oscillator": {},
}


def task_of(case, method):
    engine = discovery.engine("reference")
    instance = discovery.case(case).at(**CASES[case])
    (task,) = plan.tasks(replaced(method), instance, ("symmetry",), engine, None)
    return task


def replaced(method):
    return msgspec.structs.replace(SPECIFICATION, method=method)


def found(case, method, fault=lambda run, request: run):
    task = task_of(case, method)
    return findings_of(task, task.subject, fault)


def runs_of(task, subject, fault):
    """The runs of a subject by the engine, spoiled by `fault(run, request)`."""

    def made(variant):
        request = plan.request(task, variant)
        run, cost = task.engine.run(request)
        return CompletedRun(fault(run, request), cost)

    return all_runs(Symmetry(), subject, made)


def findings_of(task, subject, fault):
    """Findings of a subject whose runs are spoiled by `fault(run, request)`."""
    runs = runs_of(task, subject, fault)
    return {finding.quantity: finding for finding in Symmetry().judge(subject, runs)}


@pytest.mark.parametrize(
    ("case", "method", "names"),
    [
        ("two-spheres", "velocity-verlet", set(symmetry.NAMES)),
        ("two-spheres", "contact-events", set(symmetry.NAMES)),
        ("free-rigid-body", "rk4-free-body", set(symmetry.NAMES) - {"relabelled"}),
        ("free-rigid-body", "exact-free-body", set(symmetry.NAMES) - {"relabelled"}),
        ("harmonic-oscillator", "velocity-verlet", set(symmetry.NAMES) - {"relabelled", "boosted"}),
    ],
)
def test_the_reference_has_every_symmetry_of_the_scene(case, method, names):
    findings = found(case, method)
    assert set(findings) == names
    assert {name: f.sentence for name, f in findings.items() if f.outcome != "pass"} == {}


def knows_the_origin(run, request):
    return replace(run, position=run.position * (1 + 1e-9))


def knows_an_axis(run, request):
    return replace(run, velocity=run.velocity * np.array([1 + 1e-9, 1.0, 1.0]))


def drags(run, request):
    return replace(run, velocity=run.velocity * (1 - 1e-9 * run.t)[:, None, None])


def turns_one_way(run, request):
    return replace(run, omega=run.omega + np.array([0.0, 0.0, 1e-9]) * run.t[:, None, None])


def prefers_the_first_body(run, request):
    position = np.array(run.position)
    position[1:, 0] += 1e-9
    return replace(run, position=position)


def knows_a_length(run, request):
    return replace(run, position=run.position + 1e-9 * np.sign(run.t)[:, None, None])


def knows_the_time(run, request):
    return replace(run, position=run.position + 1e-9 * np.sin(run.t)[:, None, None])


def single_precision_far_away(run, request):
    return replace(run, position=run.position.astype(np.float32).astype(np.float64))


@pytest.mark.parametrize(
    ("case", "method", "fault", "name"),
    [
        ("two-spheres", "velocity-verlet", knows_the_origin, "shifted"),
        ("two-spheres", "velocity-verlet", knows_an_axis, "rotated"),
        ("two-spheres", "velocity-verlet", drags, "boosted"),
        ("two-spheres", "velocity-verlet", turns_one_way, "mirrored"),
        ("two-spheres", "velocity-verlet", prefers_the_first_body, "relabelled"),
        ("two-spheres", "velocity-verlet", knows_a_length, "rescaled"),
        ("two-spheres", "velocity-verlet", knows_the_time, "delayed"),
        ("harmonic-oscillator", "velocity-verlet", knows_the_time, "delayed"),
        ("two-spheres", "contact-events", single_precision_far_away, "shifted"),
    ],
)
def test_a_code_that_breaks_a_symmetry_is_failed_in_it(case, method, fault, name):
    finding = found(case, method, fault)[name]
    assert finding.outcome == "fail", finding.sentence


def test_a_scene_comes_back_from_every_symmetry():
    instance = discovery.case("two-spheres").at(**CASES["two-spheres"])
    engine = discovery.engine("reference")
    for name in symmetry.NAMES:
        view = symmetry.of(instance, name)
        shown = view.applied(instance.problem)
        assert shown.scene.features >= instance.scene.features - {"dimension:1", "dimension:2"}
        bodies = shown.scene.bodies
        columns = {
            column: getattr(bodies, column)[None]
            for column in ("position", "velocity", "attitude", "omega")
        }
        start = view.undone(Trajectory(t=shown.times[:1], **columns))
        for column in ("position", "velocity", "omega"):
            assert np.allclose(
                getattr(start, column)[0],
                getattr(instance.scene.bodies, column),
                rtol=0,
                atol=1e-14,
            )
    assert engine.is_reference


def knows_the_axes(size, order):
    """An error of the attitude that is `size` (h/h0)^order and depends on how space is turned."""

    coarsest = task_of("free-rigid-body", "rk4-free-body").subject.levels[0]

    def fault(run, request):
        angle = size * (request.step / coarsest) ** order * np.array([0.0, 1.0, 0.0, 0.0])
        turn = angle * (request.problem.scene.bodies.attitude[0, 0] ** 2) + np.array(
            [1.0, 0.0, 0.0, 0.0]
        )
        return replace(run, attitude=product(turn / np.linalg.norm(turn), run.attitude))

    return fault


@pytest.mark.parametrize(
    ("size", "order", "outcome"),
    [(1e-4, 4, "pass"), (1e-4, 3, "fail"), (1e-6, 0, "fail"), (3e-2, 4, "fail")],
)
def test_a_truncation_error_may_know_the_axes_of_space(size, order, outcome):
    finding = found("free-rigid-body", "rk4-free-body", knows_the_axes(size, order))["rotated"]
    assert finding.outcome == outcome, finding.sentence


def of_first_order():
    """A task of a method of first order in contacts, and its subject at four short steps."""
    specification = msgspec.structs.replace(SPECIFICATION, levels=4, method="velocity-verlet")
    instance = discovery.case("two-spheres").at(**CASES["two-spheres"])
    engine = discovery.engine("reference")
    (task,) = plan.tasks(specification, instance, ("symmetry",), engine, None)
    method = replace(task.subject.method, order_with={"contact": 1})
    levels = tuple(h / 16 for h in task.subject.levels)
    subject = replace(task.subject, method=method, levels=levels, truth=truth_of(instance))
    return task, subject


def found_in_first_order(fault):
    """Findings of a method of first order in contacts, each of whose runs is spoiled by `fault(run,
    request)`.
    """
    task, subject = of_first_order()
    return findings_of(task, subject, fault)


def changes_at_levels(fault):
    """The changes that are run at each level where rounding decides, coarse to fine."""
    task, subject = of_first_order()
    runs = runs_of(task, subject, fault)
    return [sorted(v.change for v in runs if v.level == level) for level in subject.levels]


def test_images_that_agree_to_round_off_at_the_coarsest_step_run_at_no_other():
    coarsest, *finer = changes_at_levels(lambda run, request: run)
    assert coarsest == sorted(["none", "perturbed", "perturbed", *symmetry.NAMES])
    assert finer == [[], [], []]


def test_an_image_that_differs_runs_at_the_finest_step_with_more_perturbed_starts():
    def first_body_is_light(run, request):
        if request.problem.scene.bodies.mass[0] < request.problem.scene.bodies.mass[1]:
            return run
        return replace(run, position=run.position * (1 + 1e-6))

    *_, finest = changes_at_levels(first_body_is_light)
    assert finest == ["none", *["perturbed"] * 6, "relabelled"]


def test_an_image_that_differs_as_much_as_two_perturbed_starts_needs_no_further_ones():
    """Bodies are elsewhere from any start but the plain one, as the first two of them show."""

    def elsewhere(run, request):
        moved = not np.array_equal(request.problem.scene.bodies.position, plain_position)
        return replace(run, position=run.position + 1e-6 * moved)

    _, subject = of_first_order()
    plain_position = subject.instance.scene.bodies.position
    *_, finest = changes_at_levels(elsewhere)
    assert finest.count("perturbed") == 2
    assert set(finest) > {"none", "rotated"}


def moves_the_second_body(size, order):
    """A body that is moved by `size` h^order because it is the second one [m]: relabelling changes
    it, at any step.
    """

    def fault(run, request):
        position = np.array(run.position)
        position[1:, 1, 0] += size * request.step**order
        return replace(run, position=position)

    return fault


def decides_by_a_rounding(run, request):
    """Both bodies are half a step further (2e-5 m) where the last bit of a number of its state says
    so.
    """
    position = np.array(run.position)
    position[1:, :, 0] += 2e-5 * (int(position[-1, 0, 0].view(np.int64)) & 1)
    return replace(run, position=position)


@pytest.mark.parametrize(("size", "order"), [(1e-3, 0), (1e-6, 0), (1.0, 1)])
def test_bodies_treated_unequally_are_seen_however_small_a_truncation_error_of_first_order_it_is(
    size, order
):
    finding = found_in_first_order(moves_the_second_body(size, order))["relabelled"]
    assert finding.outcome == "fail", finding.sentence


def test_what_a_rounding_decides_is_no_fault_of_any_symmetry():
    found = found_in_first_order(decides_by_a_rounding)
    assert {name: f.sentence for name, f in found.items() if f.outcome == "fail"} == {}
    assert max(finding.value for finding in found.values()) > 1e-4


def stoermer(request):
    """A linear oscillator by Stoermer's rule, x'' = (x+ - 2 x + x-)/h^2 and v = (x+ - x-)/(2 h)."""
    scene = request.problem.scene
    (spring,) = scene.all(Spring)
    square = spring.stiffness / scene.bodies.mass[0]
    anchor = np.array(spring.anchor_b)
    h = request.step
    start, speed = scene.bodies.position[0], scene.bodies.velocity[0]
    # x(h) and x(-h) from the series of the start.
    pull = -square * (start - anchor)
    places = [start - h * speed + h * h / 2 * pull, start]
    for _ in range(request.stride * (len(request.problem.times) - 1) + 1):
        pull = -square * (places[-1] - anchor)
        places.append(2 * places[-1] - places[-2] + h * h * pull)
    places = np.array(places)
    rows = 1 + request.stride * np.arange(len(request.problem.times))
    velocity = (places[rows + 1] - places[rows - 1]) / (2 * h)
    return Trajectory.of_points(request.problem.times, places[rows][:, None], velocity[:, None])


def of_differences(spoiled=lambda run, request: run):
    """Findings of Stoermer's rule from a method that claims nothing but its order."""
    task = task_of("harmonic-oscillator", "velocity-verlet")
    claims = Method(name="stoermer", control="step", order=2, summary="positions alone")
    subject = replace(
        task.subject,
        method=claims,
        levels=(2.0**-10, 2.0**-11, 2.0**-12),
        truth=truth_of(task.subject.instance),
    )

    def made(variant):
        request = plan.request(task, variant)
        return CompletedRun(spoiled(stoermer(request), request), Cost(seconds=0.0))

    runs = all_runs(Symmetry(), subject, made)
    return {finding.quantity: finding for finding in Symmetry().judge(subject, runs)}


def test_velocities_from_differences_of_positions_are_rounded_more_and_break_no_symmetry():
    found = of_differences()
    assert {name: f.sentence for name, f in found.items() if f.outcome != "pass"} == {}
    # The round-off of these velocities exceeds that of other methods.
    assert max(f.value for f in found.values()) > 1e-12


@pytest.mark.parametrize("method", ["rk4", "velocity-verlet"])
def test_runs_that_miss_a_close_passage_grow_as_they_themselves_show(monkeypatch, method):
    monkeypatch.setitem(CASES, "two-body-orbit", {"eccentricity": "0.999", "duration": "40"})
    instance = discovery.case("two-body-orbit").at(**CASES["two-body-orbit"])
    (task,) = plan.tasks(
        replaced(method), instance, ("symmetry",), discovery.engine("reference"), truth_of(instance)
    )
    record = record_of(task)
    assert {f.quantity: f.sentence for f in record.findings if f.outcome == "fail"} == {}


def rounded(column):
    """A request with numbers in single precision: masses, or the stiffness of springs."""
    if column == "mass":
        return of_bodies(mass=single)
    if column == "position":
        return of_bodies(position=single)
    return of_elements(Spring, stiffness=lambda value: float(np.float32(value)))


@pytest.mark.parametrize("column", ["mass", "position", "stiffness"])
def test_parameters_kept_in_single_precision_are_seen_in_other_units(column):
    task = task_of("harmonic-oscillator", "velocity-verlet")

    def made(variant):
        run, cost = task.engine.run(rounded(column)(plan.request(task, variant)))
        return CompletedRun(run, cost)

    runs = all_runs(Symmetry(), task.subject, made)
    outcomes = {
        finding.quantity: finding.outcome for finding in Symmetry().judge(task.subject, runs)
    }
    assert outcomes["rescaled"] == "fail"


@pytest.mark.parametrize("method", ["exact-free-body", "rk4-free-body"])
def test_other_units_make_another_needle_of_a_needle_and_nobody_is_to_blame(monkeypatch, method):
    monkeypatch.setitem(CASES, "free-rigid-body", {"inertia": "1/1048576,1,2097153/2097152"})
    rescaled = found("free-rigid-body", method)["rescaled"]
    assert (rescaled.outcome, rescaled.value > 1e-10) == ("pass", True)
    slow = found(
        "free-rigid-body",
        method,
        lambda run, request: replace(run, omega=run.omega * (1 + 1e-3 * run.t[-1] % 1)),
    )["rescaled"]
    assert slow.outcome == "fail"


def turns_with_the_axes(size, order):
    """An attitude that is off by `size` h^order, as much as the turn of space says: its error knows
    the axes of space.
    """

    def fault(run, request):
        first = request.problem.scene.bodies.attitude[0, 0] ** 2
        turn = np.array([1.0, 0.0, size * request.step**order * first, 0.0])
        off = product(turn / np.linalg.norm(turn), run.attitude)
        return replace(run, attitude=np.where((run.t > 0)[:, None, None], off, run.attitude))

    return fault


@pytest.mark.parametrize(
    ("size", "order", "outcome"), [(1e-2, 2, "pass"), (1e-2, 1, "pass"), (1e-6, 0, "fail")]
)
def test_a_truncation_error_may_know_the_axes_of_space_where_a_rounding_decides_too(
    size, order, outcome
):
    finding = found_in_first_order(turns_with_the_axes(size, order))["rotated"]
    assert finding.outcome == outcome, finding.sentence


def test_two_runs_that_a_rounding_parts_may_each_be_off_by_the_truncation_error():
    """The plain run is to one side of the right motion, and those that a rounding moves are to the
    other, each within its bound.
    """
    plain = discovery.case("two-spheres").at(**CASES["two-spheres"]).scene.bodies

    def fault(run, request):
        bodies = request.problem.scene.bodies
        is_here = np.array_equal(bodies.position, plain.position)
        is_now = request.problem.times[0] == 0.0
        if is_here and is_now and np.array_equal(bodies.velocity, plain.velocity):
            side = 1.0
        else:
            side = -1.0
        instance = discovery.case("two-spheres").at(**CASES["two-spheres"])
        tau = instance.scales.tau
        length = instance.scales.length
        within = 0.9 * (1.0 + np.abs(run.t - run.t[0]) / tau) * request.step / tau
        position = np.array(run.position)
        position[1:, 1, 0] += side * within[1:] * length
        return replace(run, position=position)

    found = found_in_first_order(fault)
    assert found["delayed"].outcome == "pass", found["delayed"].sentence
    assert found["delayed"].value > found["delayed"].bound / 4


def found_in(engine, method, case, given, fault):
    """Findings of an engine at four levels, with truth; runs of pictures are spoiled by
    `fault(run)`, and no others.
    """
    instance = discovery.case(case).at(**given)
    truth = truth_of(instance)
    specification = msgspec.structs.replace(SPECIFICATION, levels=4, method=method)
    (task,) = plan.tasks(specification, instance, ("symmetry",), discovery.engine(engine), truth)

    def made(variant):
        run, cost = task.engine.run(plan.request(task, variant))
        if variant.change in symmetry.NAMES:
            run = fault(run)
        return CompletedRun(run, cost)

    runs = all_runs(Symmetry(), task.subject, made)
    return {finding.quantity: finding for finding in Symmetry().judge(task.subject, runs)}


def off_by(part):
    """A code that puts bodies a part of the distance from the origin away from where they are."""
    return lambda run: replace(run, position=run.position * (1.0 + part))


CHOSEN = ("rebound", "bs", "harmonic-oscillator", {})
RESTING = ("mujoco", "euler", "newtons-first-law", {"member": "block", "duration": "9/4"})


@pytest.mark.parametrize(
    ("where", "part", "least"), [(CHOSEN, 1e-10, 1e-10), (RESTING, 1e-8, 1e-9)]
)
def test_pictures_are_as_near_as_steps_that_are_chosen_and_iterations_over_contacts_allow(
    where, part, least
):
    """A tolerance of 1e-10, and contacts that are solved to round-off, leave less than their
    truncation errors may be.
    """
    sound = found_in(*where, lambda run: run)
    spoiled = found_in(*where, off_by(part))
    assert {name: f.sentence for name, f in sound.items() if f.outcome != "pass"} == {}
    assert sound["shifted"].bound < least
    assert spoiled["shifted"].outcome == "fail", spoiled["shifted"].sentence


def grown_where_relabelled(part):
    """Velocities that go wrong by a part of themselves where the heavier sphere comes first."""

    def after(request, run):
        mass = request.problem.scene.bodies.mass
        if mass[0] <= mass[1]:
            return run
        grown = (1 + part * run.t / run.t[-1])[:, None, None]
        return replace(run, velocity=run.velocity * grown)

    return Fault(
        name="order of bodies",
        kind="",
        sentence="",
        on=(),
        sees=("symmetry", "relabelled"),
        after=after,
    )


@pytest.mark.parametrize(("part", "outcome"), [(0.0, "pass"), (1e-8, "fail"), (1e-6, "fail")])
def test_a_difference_far_below_that_of_a_decision_is_not_excused_by_one(part, outcome):
    """Of two spheres that touch at the start rounding decides whether the first step is damped.

    That is worth a thousandth here, and a picture that differs by a millionth has decided alike.
    """
    engine = grown_where_relabelled(part).carrier(discovery.engine("mujoco"))
    given = {"masses": "1,3", "damping": "2", "cutoff": "zero_force", "samples": "16"}
    instance = discovery.case("two-spheres").at(**given)
    truth = truth_of(instance)
    specification = replaced("euler")
    (task,) = plan.tasks(specification, instance, ("symmetry",), engine, truth)
    (found,) = (f for f in record_of(task).findings if f.quantity == "relabelled")
    assert found.outcome == outcome


@pytest.mark.parametrize("friction", ["1/2", "39.5"])
@pytest.mark.parametrize("method", ["drift-kick", "verlet-half", "midpoint", "rk4"])
def test_friction_that_alternates_about_no_slip_breaks_no_symmetry(method, friction):
    """Two spheres that meet head on have no slip at all along an axis, and one of a rounding when
    the scene is turned, of which explicit friction makes a step's worth.
    """
    instance = discovery.case("two-spheres").at(
        damping="1", friction=friction, duration="0.625", samples="16"
    )
    specification = Specification(
        name="head on", case=[], levels=3, method=method, checks=["symmetry"], most_steps=2e3
    )
    (task,) = plan.tasks(specification, instance, (), RightSpheres(), truth_of(instance), "")
    record = record_of(task)
    assert [f.sentence for f in record.findings if f.outcome in ("fail", "error")] == []
    assert any(f.quantity == "rotated" for f in record.findings)
