"""Which scenes a check is for, which runs it asks for and what decides, one condition at a time."""

from types import SimpleNamespace

import numpy as np
import pytest

from refdem.checks import (
    _crossings,
    contact_impulse,
    cooling,
    determinism,
    limit,
    lyapunov,
    rigid_impact,
    roughness,
    symmetry,
    top,
)
from refdem.core import judgement, refinement
from refdem.core.check import Subject
from refdem.core.quantity import Quantity
from refdem.core.symmetry import Symmetry
from refdem.core.variant import Variant
from refdem.scene import Body, Polyhedron, Scene, Sphere
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.handmade import SCALES, findings, instance, method, near, standing, truth

POINT = Body(mass=2.0, position=(3.0, 0.0, 0.0))
BALL = Body(mass=2.0, inertia=(0.8,) * 3, shape=Sphere(radius=1.0))
FAR_BALL = Body(mass=2.0, inertia=(0.8,) * 3, position=(8.0, 0.0, 0.0), shape=Sphere(radius=1.0))
SOFT = Contact(law="linear", stiffness=70.0)
RIGID = Contact(law="rigid", restitution=0.5)
ROUGH = {"friction": 1000.0, "tangential_stiffness": 20.0}
BOX = PeriodicBox(size=40.0)
GRAVITY = UniformGravity(g=(0.0, 0.0, -2.0))
LEVELS = (0.5, 0.25, 0.125)


def subject(bodies=(POINT,), elements=(), levels=LEVELS, claims=None, known=None, **more):
    """What a check is asked about, by a method of second order unless `claims` says other."""
    of = instance(list(bodies), tuple(elements), **more)
    return Subject(of, claims or method(), levels, known)


# Scenes that a check is for


@pytest.mark.parametrize(
    ("laws", "is_rough"),
    [
        ([Contact(law="linear", stiffness=70.0, **ROUGH)], True),
        ([Contact(law="linear", stiffness=70.0, damping=0.5, **ROUGH)], False),
        ([Contact(law="hertz", stiffness=70.0, **ROUGH)], False),
        ([], False),
    ],
)
def test_kinetic_theory_of_rough_spheres_needs_one_linear_law_without_damping(laws, is_rough):
    asked = subject([BALL], [*laws, BOX], quantities={"temperature": 1.0})
    assert (roughness.CHECK.applies(asked) is None) == is_rough


@pytest.mark.parametrize(
    ("elements", "bodies", "is_top"),
    [
        ([BallJoint(a=0)], 1, True),
        ([BallJoint(a=0), GRAVITY], 1, True),
        ([BallJoint(a=0), Spring(a=0, b=-1, stiffness=1.0)], 1, False),
        ([GRAVITY], 1, False),
        ([BallJoint(a=0), BallJoint(a=0, b=1)], 2, False),
        ([BallJoint(a=0)], 2, False),
    ],
)
def test_a_top_is_one_body_on_one_joint_of_the_world(elements, bodies, is_top):
    whirling = Body(mass=2.0, inertia=(1.0, 1.0, 0.5))
    assert (top.CHECK.applies(subject([whirling] * bodies, elements)) is None) == is_top


@pytest.mark.parametrize(("name", "terms", "of_claim"), [("joint", 1.0, 0.0), ("L_z", 3.0, 2.0)])
def test_a_top_whose_coarse_steps_change_nothing_is_held_to_round_off(name, terms, of_claim):
    whirling = Body(mass=2.0, inertia=(1.0, 1.0, 0.5))
    held = subject([whirling], [BallJoint(a=0)], levels=(2.0**-3, 2.0**-4, 2.0**-5))
    nothing = [np.zeros(len(held.instance.times))] * 3
    found = top.CHECK._constant(held, name, nothing, {"L_z": terms})
    # 20 c u sqrt(n) for each term, and one c u sqrt(n) for each term beyond the first.
    rounding = held.round_off(2.0**-5)
    of_turns = 0.0
    if name == "L_z":
        of_turns = refinement.turning(held.instance, held.method, 2.0**-5)
    assert found.bound == near((20 * terms + of_claim) * rounding + of_turns, rel=1e-12)


@pytest.mark.parametrize(
    ("bodies", "elements", "are_alone"),
    [
        ((BALL, FAR_BALL), [RIGID], True),
        ((BALL, FAR_BALL), [RIGID, Plane(point=(0.0, 0.0, -9.0))], True),
        ((BALL, FAR_BALL), [RIGID, Plane(point=(0.0, 0.0, -9.0)), GRAVITY], True),
        ((BALL, FAR_BALL), [RIGID, Plane(point=(0.0, 0.0, 9.0)), GRAVITY], False),
        ((BALL, FAR_BALL), [RIGID, Spring(a=0, b=-1, stiffness=1.0)], False),
        ((BALL, Body(mass=1.0, position=(0.0, 0.0, 4.0))), [RIGID], False),
    ],
)
def test_impacts_are_alone_among_spheres_that_nothing_else_moves(bodies, elements, are_alone):
    assert _crossings.is_impacts_alone(subject(bodies, elements).instance.scene) == are_alone


@pytest.mark.parametrize(
    ("bodies", "elements", "control", "is_one"),
    [
        ((BALL, FAR_BALL), [SOFT], "step", True),
        ((BALL, FAR_BALL), [SOFT], "tolerance", False),
        ((BALL, FAR_BALL), [SOFT, GRAVITY], "step", False),
        ((BALL, FAR_BALL), [RIGID], "step", False),
        ((BALL, FAR_BALL), [GRAVITY], "step", False),
        ((BALL,), [SOFT], "step", False),
        ((BALL, FAR_BALL), [Contact(law="linear", stiffness=70.0, **ROUGH)], "step", False),
    ],
)
def test_one_collision_is_two_bodies_with_a_smooth_contact_and_nothing_else(
    bodies, elements, control, is_one
):
    asked = subject(bodies, elements, claims=method(control))
    assert symmetry._is_one_collision(asked) == is_one


@pytest.mark.parametrize(
    ("claims", "levels", "word"),
    [
        ({}, LEVELS, None),
        ({"velocity_time": "minus-half-step"}, LEVELS, "lag"),
        ({"control": "tolerance"}, LEVELS, "not a fixed step"),
        ({}, LEVELS[:2], "three steps"),
        ({}, LEVELS[:1], "three steps"),
    ],
)
def test_a_limit_is_drawn_from_three_steps_with_velocities_of_their_samples(claims, levels, word):
    said = limit.CHECK.left_out(subject(levels=levels, claims=method(**claims)))
    assert (said is None) if word is None else (word in said)


@pytest.mark.parametrize(
    ("order", "located", "word"),
    [
        (1, False, None),
        (2, False, "singular"),
        (3, False, "singular"),
        (4, False, "kinks"),
        (2, True, None),
    ],
)
def test_no_limit_is_drawn_where_a_singular_force_leaves_the_next_order(order, located, word):
    """Quadratic drag makes an error of order 3, which scatters with the place of the turn."""
    drawn = subject(
        elements=[Drag(a=0, coefficient=0.5)], claims=method(order=order, locates_events=located)
    )
    said = limit.CHECK.left_out(drawn)
    assert (said is None) if word is None else (word in said)


# Runs that are asked for, and which of them decide


def test_the_run_at_twice_the_step_shows_what_iterations_leave():
    iterates = subject((BALL, FAR_BALL), [RIGID])
    assert symmetry._coarser_run(iterates) == (Variant(0.25),)
    assert symmetry._coarser_run(subject((BALL, FAR_BALL), [SOFT])) == ()
    single = subject((BALL, FAR_BALL), [RIGID], levels=(0.5,))
    assert symmetry._coarser_run(single) == ()


@pytest.mark.parametrize(
    ("control", "finest", "is_judged"),
    [("step", 0.25, True), ("step", 1.0, False), ("exact", 0.0, False)],
)
def test_denser_output_is_held_to_the_bit_where_steps_are_fixed_and_fit(control, finest, is_judged):
    asked = subject(levels=(finest,), claims=method(control))
    dense = instance([POINT], times=tuple(0.5 * k for k in range(17)))

    def run(variant):
        if variant.change == "denser_output":
            return standing(dense)
        return standing(asked.instance)

    assert ("output-rate" in findings(determinism.CHECK, asked, run)) == is_judged


def test_a_perturbed_start_that_equals_the_plain_one_decides_nothing():
    asked = subject(quantities={"x": 1.0}, is_chaotic=True)
    (found,) = findings(lyapunov.CHECK, asked, standing(asked.instance)).values()
    assert found.outcome == "undecided"
    assert "equals the plain one" in found.sentence


@pytest.mark.parametrize(("restitution", "is_elastic"), [(1.0, True), (0.875, False)])
def test_velocities_of_a_gas_stay_maxwellian_where_nothing_is_lost(restitution, is_elastic):
    balls = [
        Body(
            mass=2.0,
            inertia=(0.8,) * 3,
            position=(float(4 * k), 0.0, 0.0),
            velocity=(float(k % 3 - 1), float(k % 5 - 2), float(k % 7 - 3)),
            shape=Sphere(radius=0.5),
        )
        for k in range(10)
    ]
    law = Contact(law="rigid", restitution=restitution)
    known = truth((0.0, 2.0, 4.0, 6.0, 8.0), {}, scalars={"collision_frequency": (0.25, 0.0)})
    asked = subject(balls, [law, BOX], known=known, quantities={"temperature": 1.0})
    run = standing(asked.instance)
    asked.instance.case.observe = lambda p, trajectory: {"temperature": np.full(5, 4.0)}
    found = findings(cooling.CHECK, asked, run)
    assert any("distribution" in name or "kurtosis" in name for name in found) == is_elastic


# What a finding is made of


def test_two_spheres_meet_where_their_distance_is_the_sum_of_radii():
    scene = Scene.of([BALL, FAR_BALL], [RIGID])
    of = instance([BALL, FAR_BALL], [RIGID])
    velocity = np.zeros((5, 2, 3))
    velocity[:, 0] = (3.0, 0.0, 0.0)
    position = np.zeros((5, 2, 3))
    position[:, 0] = (1.0, 2.0, 0.0)
    position[:, 1] = (8.0, 2.0, 0.0)
    run = standing(of, position=position, velocity=velocity)
    # 7 m apart, 2 m between centres at the touch, at 3 m/s.
    normal, when = rigid_impact._meeting(scene, run)
    assert when == near(5.0 / 3.0, rel=1e-14)
    assert normal == pytest.approx([1.0, 0.0, 0.0])
    aside = standing(of, position=position + np.array([[0, 0, 0], [0, 2.5, 0]]), velocity=velocity)
    assert rigid_impact._meeting(scene, aside) is None
    assert rigid_impact._meeting(scene, standing(of, position=position)) is None
    floor = Scene.of([BALL], [RIGID, Plane(point=(0.0, 0.0, -4.0), normal=(0.0, 0.0, 1.0))])
    falling = standing(instance([BALL]), velocity=[[[0, 0, -2.0]]] * 5)
    normal, when = rigid_impact._meeting(floor, falling)
    assert (normal.tolist(), when) == ([0.0, 0.0, -1.0], 1.5)


def test_the_impulse_across_the_normal_is_what_the_push_leaves():
    of = instance([BALL, FAR_BALL], [SOFT], times=(0.0, 2.0))
    velocity = np.zeros((2, 2, 3))
    velocity[0, 0] = (3.0, 1.0, 0.0)
    velocity[1, 0] = (-1.0, 0.25, 0.0)
    run = standing(of, velocity=velocity)
    normal = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    push, across, turn = contact_impulse._impulses(of.scene, run, normal)
    assert push.tolist() == [2.0 * 4.0]
    assert across.tolist() == [2.0 * 0.75]
    assert turn.tolist() == [0.0]


def test_energy_of_a_rough_gas_is_compared_with_that_of_its_first_sample():
    ball = Body(mass=2.0, inertia=(0.8,) * 3, velocity=(3.0, 0, 0), shape=Sphere(radius=1.0))
    of = instance([ball], [SOFT, BOX], times=(0.0, 1.0, 2.0))
    velocity = np.array([[[3.0, 0, 0]], [[6.0, 0, 0]], [[6.0, 0, 0]]])
    found = roughness.CHECK._energy(of.scene, standing(of, velocity=velocity), 0.5)
    # 9 J become 36 J.
    assert found.value == near(3.0, rel=1e-13)


def test_a_roll_that_begins_early_or_late_grows_over_the_shortest_time():
    bodies = [
        Body(
            mass=2.0,
            inertia=(0.8,) * 3,
            position=(0.0, 1.0, 0.0),
            velocity=(3.0, 0.0, 0.0),
            shape=Sphere(radius=1.0),
        )
    ]
    elements = (
        Contact(law="rigid", restitution=0.0, friction=0.25),
        Plane(point=(0.0, 0.0, 0.0), normal=(0.0, 1.0, 0.0)),
        UniformGravity(g=(0.0, -8.0, 0.0)),
    )
    known = truth((0.0, 8.0), {}, scalars={"roll_time": (0.5, 0.0)})
    asked = subject(bodies, elements, known=known, quantities={"vx": 4.0, "omega": 2.0})
    (crossing,) = _crossings.sticking(asked, known)["stick"]
    assert crossing.growth == 1 / SCALES.tau
    assert crossing.time == 0.5
    none = truth((0.0, 8.0), {})
    assert _crossings.sticking(asked, none) == {"stick": []}


# Truth, attitudes and symmetries


def test_why_there_is_no_truth_is_said_by_who_knows_it():
    def asked(reason, known):
        return SimpleNamespace(truth_reason=reason, truth=known)

    ends = SimpleNamespace(reason="the motion ends")
    assert judgement.no_truth(asked("", ends)) == "the motion ends"
    assert judgement.no_truth(asked("it was not asked for", ends)) == "it was not asked for"
    assert judgement.no_truth(asked("", None)) == "no certified truth"
    assert judgement.no_truth(asked("", SimpleNamespace(reason=""))) == "no certified truth"


def spun(angle):
    """Quaternion components of a turn about z."""
    return {"qw": np.cos(angle / 2), "qx": 0.0, "qy": 0.0, "qz": np.sin(angle / 2)}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_attitude_is_ahead_by_the_vector_of_its_small_rotation(sign):
    names = judgement.ATTITUDE
    true = dict(zip(names, spun(0.5).values(), strict=True))
    seen = dict(zip(names, (sign * part for part in spun(0.5 + 1e-3).values()), strict=True))
    quantities = [Quantity(name, "", 1.0, group="attitude") for name in names]
    of = instance([BALL], quantities=quantities, times=(0.0, 2.0))
    of.case.observe = lambda p, run: {name: np.full(2, value) for name, value in seen.items()}
    known = truth((0.0, 2.0), {name: [value] * 2 for name, value in true.items()})
    asked = Subject(of, method(), LEVELS, known)
    rows = judgement.signed(asked, standing(of), known, 2)
    assert rows.shape == (3, 2)
    assert rows[2] == pytest.approx(1e-3, rel=1e-6)
    assert rows[:2] == pytest.approx(0.0, abs=1e-15)
    # Without a certified attitude there is nothing to compare.
    bare = truth((0.0, 2.0), {})
    assert judgement.signed(asked, standing(of), bare, 2).size == 0


def test_a_symmetry_that_says_nothing_changes_nothing():
    of = instance([Body(mass=2.0, inertia=(1.0, 2.0, 2.5), attitude=(0.6, 0.8, 0.0, 0.0))])
    assert Symmetry().turn.tolist() == [1.0, 0.0, 0.0, 0.0]
    assert Symmetry().applied(of.motion).scene.bodies.attitude.tolist() == [[0.6, 0.8, 0.0, 0.0]]


def test_a_mirror_keeps_the_length_of_an_attitude():
    of = instance([Body(mass=2.0, inertia=(1.0, 2.0, 2.5), attitude=(0.5, 0.5, 0.5, 0.5))])
    seen = Symmetry(mirrored=True).applied(of.motion).scene.bodies.attitude
    assert seen.tolist() == [[0.5, 0.5, -0.5, -0.5]]


def test_corners_of_a_polyhedron_are_measured_in_the_unit_of_length():
    corners = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    shape = Polyhedron(vertices=corners, faces=faces)
    of = instance([Body(mass=2.0, inertia=(1.0, 1.0, 1.0), shape=shape)])
    (seen,) = Symmetry(units=(1.0, 4.0, 1.0)).applied(of.motion).scene.bodies.shape
    assert seen.vertices == tuple(tuple(4.0 * x for x in corner) for corner in corners)


def test_only_the_anchor_at_the_world_is_a_place_in_space():
    rod = Rod(a=0, b=-1, length=1.0, anchor_a=(0.5, 0.0, 0.0), anchor_b=(0.25, 0.0, 0.0))
    between = Rod(a=0, b=1, length=1.0, anchor_a=(0.5, 0.0, 0.0), anchor_b=(0.25, 0.0, 0.0))
    ball = Body(mass=2.0, inertia=(1.0, 1.0, 1.0))
    of = instance([ball, ball], (rod, between))
    first, second = Symmetry(shift=np.array([7.0, 0.0, 0.0])).applied(of.motion).scene.elements
    assert (first.anchor_a, first.anchor_b) == ((0.5, 0.0, 0.0), (7.25, 0.0, 0.0))
    assert (second.anchor_a, second.anchor_b) == ((0.5, 0.0, 0.0), (0.25, 0.0, 0.0))


def test_the_first_step_is_a_sample_where_no_more_steps_are_allowed():
    of = instance([POINT])
    # Four samples: one step in each is all that four steps allow, however long the motion takes.
    assert refinement.levels(of, method(), 4, 4.0)[:1] in {(2.0,), ()}
    assert refinement._first_step(of, method(), 2.0, 4.0, None) == 2.0
    assert refinement._first_step(of, method(), 2.0, 8.0, None) == 1.0
