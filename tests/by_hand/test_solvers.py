"""Formulas, limits and claims of single solvers, as numbers that are computed on paper."""

from math import cos, log, sin, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Ensemble, Motion, Request
from refdem.engines.reference import ENGINE
from refdem.errors import EngineError
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _particles, _single_point, _sliding, exact_drag, impacts
from refdem.solvers._kernel_solver import KernelCall
from refdem.solvers._mindlin_spring import Spring, course
from refdem.solvers._scene_pattern import ANY, ONE, OPTIONAL, SOME, TWO

NEAR = {"rel": 1e-13}


def spheres(*positions, omega=(0.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.0), radius=0.5):
    """Spheres at these places; the first moves."""
    moving = Body(
        mass=1.0,
        inertia=(1.0, 1.0, 1.0),
        position=positions[0],
        velocity=velocity,
        omega=omega,
        shape=Sphere(radius=radius),
    )
    others = [
        Body(mass=1.0, inertia=(1.0, 1.0, 1.0), position=position, shape=Sphere(radius=radius))
        for position in positions[1:]
    ]
    return [moving, *others]


# Claims --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "order"),
    [
        ("velocity-verlet", 2),
        ("rk4", 4),
        ("ensemble-symplectic", 8),
        ("ensemble-symplectic-10", 10),
    ],
)
def test_a_method_claims_the_order_of_its_formula(name, order):
    assert ENGINE.method(name).order == order


@pytest.mark.parametrize(
    ("count", "allowed"),
    [
        (ANY, {0, 1, 2, 3}),
        (OPTIONAL, {0, 1}),
        (ONE, {1}),
        (TWO, {2}),
        (SOME, {1, 2, 3}),
    ],
)
def test_a_count_allows_what_its_name_says(count, allowed):
    assert {number for number in range(4) if number in count} == allowed


# Units and places ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("times", "unit"),
    [
        ([1.0], 1.0),
        ([2.0**20], 1.0),
        ([2.0**-20], 1.0),
        ([1.5 * 2.0**20], 2.0**21),
        ([0.7 * 2.0**-20], 2.0**-21),
        ([2.0**30, 2.0**25], 2.0**25),
        ([0.0, float("inf")], 1.0),
    ],
)
def test_seconds_serve_from_a_microsecond_to_twelve_days(times, unit):
    assert _single_point.time_unit(times) == unit


@pytest.mark.parametrize(
    ("far", "is_counted_from_middle"),
    [(15.9 * 4.5, False), (16.1 * 4.5, True), (24.5 * 4.5, True)],
)
def test_spheres_sixteen_sizes_from_the_origin_are_counted_from_their_middle(
    far, is_counted_from_middle
):
    # Along y the centres span 4 m, and a radius is 1/2 m: the size is 4.5 m.
    bodies = spheres((0.0, far - 2.0, 0.0), (1.0, far + 2.0, 0.0))
    scene = Scene.of(bodies, [Contact(law="linear", stiffness=8.0)])
    expected = [0.0, 0.0, 0.0]
    if is_counted_from_middle:
        expected = [0.5, far, 0.0]
    assert _particles.middle(scene) == pytest.approx(expected)


def test_a_size_is_measured_along_each_axis_over_all_bodies():
    # Each sphere's own coordinates lie within 1 m of each other, the centres 100 m apart.
    bodies = spheres((-50.0, -50.0, -50.0), (300.0, 300.0, 300.0))
    scene = Scene.of(bodies, [Contact(law="linear", stiffness=8.0)])
    assert _particles.middle(scene).tolist() == [0.0, 0.0, 0.0]


def test_a_central_field_holds_the_origin():
    far = spheres((1e6, 0.0, 0.0), (1e6 + 2.0, 0.0, 0.0))
    field = CentralField(gm=1.0)
    assert _particles.middle(Scene.of(far, [field])).tolist() == [0.0, 0.0, 0.0]


# Planes of slip ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("omega", "velocity", "is_plane"),
    [
        # All along the line of centres, spins too or none: every plane through it will do.
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), True),
        ((3.0, 0.0, 0.0), (1.0, 0.0, 0.0), True),
        ((0.0, 0.0, 3.0), (1.0, 0.0, 0.0), True),
        ((0.0, 0.0, 3.0), (1.0, 1.0, 0.0), True),
        ((0.0, 3.0, 0.0), (1.0, 1.0, 0.0), False),
    ],
)
def test_slip_stays_in_a_plane_where_spins_are_perpendicular_to_all_else(omega, velocity, is_plane):
    bodies = spheres((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), omega=omega, velocity=velocity)
    scene = Scene.of(bodies, [Contact(law="linear", stiffness=8.0, friction=0.25)])
    assert _sliding._in_a_plane(scene) == is_plane


# Falls and slides ----------------------------------------------------------------------------


def test_a_throw_up_against_quadratic_drag():
    start = -1.5
    s = np.array([0.0, 0.25, 0.5, 0.75])
    way, speed = exact_drag.fallen(start, s)
    # u' = 1 + u^2 for u < 0: u = tan(s + arctan u0), X' = u.
    assert speed == pytest.approx(np.tan(s + np.arctan(start)), **NEAR)
    assert way == pytest.approx([-log(cos(t) - start * sin(t)) for t in s], rel=1e-13, abs=1e-16)


def test_a_block_slides_down_by_half_of_a_t_squared():
    instance = discovery.case("block-on-slope").at(friction="1/8")
    problem = instance.problem
    run = ENGINE.run(Request(problem=problem, method="exact-slide"))[0]
    scene = problem.scene
    (contact,) = scene.all(Contact)
    (field,) = scene.all(UniformGravity)
    way = np.linalg.norm(run.position[:, 0] - run.position[0, 0], axis=-1)
    elapsed = run.t - run.t[0]
    speed = np.linalg.norm(run.velocity[:, 0], axis=-1)
    assert elapsed[1] != 1.0
    # v = a t and s = a t^2/2 = v t/2 from rest, whatever the acceleration is.
    assert way == pytest.approx(speed * elapsed / 2, **NEAR)
    assert 0 < speed[-1] / elapsed[-1] < float(np.linalg.norm(field.g))
    assert contact.friction > 0


def test_a_body_drifts_from_where_it_was_at_its_first_sample():
    instance = discovery.case("dissipating-body").at()
    body = Body(
        mass=1.0,
        inertia=tuple(instance.scene.bodies.inertia[0]),
        omega=tuple(instance.scene.bodies.omega[0]),
        velocity=(1.0, -2.0, 0.5),
        position=(3.0, 0.0, 0.0),
    )
    scene = Scene.of([body], instance.scene.elements)
    times = np.array([2.0, 2.5, 3.5])
    run = ENGINE.run(Request(problem=Motion(scene, times), method="dissipating-body"))[0]
    drift = np.outer([0.0, 0.5, 1.5], [1.0, -2.0, 0.5])
    assert run.position[:, 0] == pytest.approx(np.array([3.0, 0.0, 0.0]) + drift, **NEAR)


# Catches -------------------------------------------------------------------------------------


def flight(position, velocity, times):
    """The run of a mass past a hook at the origin that catches within 1 m."""
    scene = Scene.of(
        [Body(mass=1.0, position=position, velocity=velocity)], [Catch(a=0, radius=1.0)]
    )
    return ENGINE.run(Request(problem=Motion(scene, np.array(times)), method="exact-capture"))[0]


@pytest.mark.parametrize(
    ("position", "times", "events"),
    [
        # 4 m before the nearest point at 2 m/s: it is caught after 2 s.
        ((-4.0, 0.5, 0.0), (0.0, 3.0), [(2.0, "catch", 0)]),
        ((-4.0, 0.5, 0.0), (5.0, 7.0), [(7.0, "catch", 0)]),
        ((-4.0, 0.5, 0.0), (0.0, 1.0), []),
        # Out of reach, and past the hook.
        ((-4.0, 1.5, 0.0), (0.0, 3.0), []),
        ((4.0, 0.5, 0.0), (0.0, 3.0), []),
        # At the nearest point but for a rounding, on either side of it: caught at once.
        ((2.0**-56, 0.5, 0.0), (0.0, 3.0), [(0.0, "catch", 0)]),
        ((-(2.0**-56), 0.5, 0.0), (0.0, 3.0), [(0.0, "catch", 0)]),
    ],
)
def test_a_catch_is_an_event_of_its_body_where_it_is_within_reach_and_in_time(
    position, times, events
):
    run = flight(position, (2.0, 0.0, 0.0), times)
    assert [(event.time, event.kind, event.body) for event in run.events] == events


def test_a_contact_that_ends_is_an_event_of_the_first_body():
    instance = discovery.case("two-spheres").at(
        damping="0", angle="1/4", tangential_stiffness="64", friction="1/4"
    )
    run = ENGINE.run(Request(problem=instance.problem, method="oblique-contact"))[0]
    assert [(event.kind, event.body) for event in run.events] == [("release", 0)]


# Ensembles -----------------------------------------------------------------------------------


def test_an_ensemble_of_rods_of_any_length_keeps_its_rates_and_counts_its_steps():
    length = 4.0
    angle = np.array([0.5, -1.0])
    rate = np.array([2.0, 0.25])
    across = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    place = length * np.stack([np.sin(angle), -np.cos(angle), 0 * angle], axis=-1)
    speed = length * rate[:, None] * across
    body = Body(mass=1.0, position=tuple(place[0]), velocity=tuple(speed[0]))
    gravity = UniformGravity(g=(0.0, -8.0, 0.0))
    problem = Ensemble(
        scene=Scene.of([body], [Rod(a=0, b=-1, length=length), gravity]),
        times=np.array([0.0, 0.5, 1.0]),
        position=place[:, None],
        velocity=speed[:, None],
    )
    request = Request(problem=problem, method="ensemble-symplectic", step=0.5 / 64)
    run, cost = ENGINE.run(request)
    assert cost.steps == 2 * 64
    # T/m - g.r of a rod is conserved: v^2/2 - 8 * 4 cos(angle), to the h^8 of the method.
    before = 0.5 * (length * rate) ** 2 - 32.0 * np.cos(angle)
    velocity = run.values["velocity"][-1, :, 0]
    position = run.values["position"][-1, :, 0]
    after = 0.5 * np.sum(velocity**2, axis=-1) + 8.0 * position[:, 1]
    assert after == pytest.approx(before, rel=1e-10)


# Impacts without end -------------------------------------------------------------------------


def test_a_run_of_too_many_impacts_says_which_sample_it_did_not_reach():
    times = np.array([0.0, 1.0, 2.0, 3.0])
    scene = Scene.of(spheres((0.0, 0.0, 0.0), (2.0, 0.0, 0.0)), [])
    request = SimpleNamespace(problem=SimpleNamespace(times=times, scene=scene))
    solver = impacts.METHOD
    rows = [np.zeros((4, 2, 3))] * 3 + [np.zeros((4, 2, 4))]
    call = KernelCall(
        function="",
        inputs=(),
        clock=(),
        outputs=(np.empty(1), np.empty((1, 3)), np.zeros(4), *rows),
    )
    with pytest.raises(EngineError, match=r"impacts did not lead to t = 1 s"):
        solver.finish(request, call, -1)
    with pytest.raises(EngineError, match=r"between t = 1 s and 2 s spheres come to rest"):
        solver.finish(request, call, -6)


# Tangential slip -----------------------------------------------------------------------------


@pytest.mark.parametrize("root", [1e-2, 1e-3, 1e-6])
def test_the_first_moments_of_a_contact_are_found_by_its_overlap(root):
    # There d' = sqrt(1 - d^(5/2)) is 1 to the last bits and says nothing; q = p d for d = t.
    overlap = root**2
    found = course(Spring(ratio=1.3, friction=0.1), 3.0)
    slip, distance = found.at(overlap, sqrt(1 - overlap**2.5))
    assert slip == pytest.approx(3.0, rel=1e-9)
    assert distance == pytest.approx(3.0 * overlap, rel=1e-9)
