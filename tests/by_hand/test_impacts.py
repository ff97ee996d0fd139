"""What impacts change, and what a sound method may be off by there, with numbers that are computed
on paper: balls of radii 1 and 1/2 m, of 2 and 1 kg.

SCALES: L = 4 m, tau = 1/2 s, L/tau = 8 m/s, T = 8 s.
"""

from math import inf, sqrt

import numpy as np
import pytest

from refdem.checks import _impacts, _impulses, _sphere_on_plane, momentum, rigid_impact
from refdem.checks._impacts import Impact, Window
from refdem.core import discovery
from refdem.core.check import Subject
from refdem.core.variant import Variant
from refdem.scene import Body, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.handmade import U, findings, instance, method, near, standing, truth

RIGID_IMPACT = discovery.check("rigid-impact")
MOMENTUM = discovery.check("momentum")
BIG = Body(mass=2.0, inertia=(0.8,) * 3, shape=Sphere(radius=1.0))
SMALL = Body(mass=1.0, inertia=(0.1,) * 3, position=(4.0, 0.0, 0.0), shape=Sphere(radius=0.5))
LAW = Contact(law="rigid", restitution=0.5, friction=0.25)
FALL = UniformGravity(g=(0.0, 0.0, -2.0))
FLOOR = Plane()
TIMES = (0.0, 1.0, 2.0, 3.0, 4.0)


def body(of, **columns):
    """A body with other columns."""
    values = {name: getattr(of, name) for name in of.__struct_fields__} | columns
    return Body(**values)


LISTED = {
    "impact_1": (0.5, 0.0625),
    "impact_1_closing": (3.0, 0.25),
    "impact_1_body": (1.0, 0.0),
    "impact_1_other": (0.0, 0.0),
    "impact_2": (1.75, 0.125),
    "impact_2_closing": (2.0, 0.0),
    "impact_2_body": (1.0, 0.0),
    "impact_4": (3.0, 0.0),
}


def test_the_list_of_impacts_is_read_up_to_its_first_gap_with_the_slowest_closing():
    first, second = _impacts.listed(LISTED)
    assert first == Impact(0.5, 0.0625, 2.75, (1, 0))
    assert second == Impact(1.75, 0.125, 2.0, (1,))
    assert _impacts.listed({}) == []


def test_the_shortest_wait_is_that_of_one_body():
    impacts = [
        Impact(1.0, 0.0, 1.0, (0, 1)),
        Impact(1.25, 0.0, 1.0, (2,)),
        Impact(3.0, 0.0, 1.0, (1, 2)),
        Impact(4.5, 0.0, 1.0, (0,)),
    ]
    assert _impacts.shortest_wait(impacts) == 1.75
    assert _impacts.shortest_wait(impacts[:2]) == inf


def sequence(bodies=(BIG, SMALL), elements=(LAW, FALL, FLOOR), times=TIMES, **more):
    """An instance of balls that fall on a floor and on each other."""
    return instance(list(bodies), elements, times=times, **more)


@pytest.mark.parametrize(
    ("bodies", "elements", "is_one"),
    [
        ((BIG, SMALL), (LAW, FALL, FLOOR), True),
        ((BIG,) * 16, (LAW,), True),
        ((BIG,) * 17, (LAW,), False),
        ((BIG, SMALL), (FALL, FLOOR), False),
        ((BIG, SMALL), (Contact(law="linear", stiffness=1.0),), False),
        ((BIG, body(SMALL, fixed=True)), (LAW,), False),
        ((BIG, SMALL), (LAW, Spring(a=0, b=-1, stiffness=1.0)), False),
        ((BIG, Body(mass=1.0, position=(9.0, 0, 0))), (LAW,), False),
    ],
)
def test_a_sequence_is_that_of_a_few_free_rigid_spheres(bodies, elements, is_one):
    assert _impacts.is_sequence(instance(list(bodies), elements).scene) == is_one


def test_gravity_is_the_sum_of_its_fields():
    of = sequence(elements=(LAW, FALL, UniformGravity(g=(1.0, 0.0, -0.5))))
    assert _impacts.falling(of.scene).tolist() == [1.0, 0.0, -2.5]


def test_a_gap_closes_in_units_of_what_a_scale_of_every_place_changes_it_by():
    of = sequence()
    assert "dimension:3" in of.scene.features
    rate, bend = _impacts.gap_rates(of, Impact(1.0, 0.0, 3.0, (1,)))
    assert rate == near(3.0 / (4.0 * sqrt(3.0)), rel=1e-14)
    assert bend == near(2.0 / (4.0 * sqrt(3.0)), rel=1e-14)
    rate, bend = _impacts.gap_rates(of, Impact(1.0, 0.0, 3.0, (0, 1)))
    assert rate == near(3.0 / (8.0 * sqrt(3.0)), rel=1e-14)
    # (2 L/tau)^2/(R_1 + R_2)
    assert bend == near(256.0 / 1.5 / (8.0 * sqrt(3.0)), rel=1e-14)
    line = sequence(elements=(LAW,))
    assert "dimension:1" in line.scene.features
    assert _impacts.gap_rates(line, Impact(1.0, 0.0, 3.0, (0, 1))) == (3.0 / 8.0, 0.0)


def listing(*impacts):
    """The scalars of a list of (time, radius, closing, bodies)."""
    scalars = {}
    for number, (time, radius, closing, bodies) in enumerate(impacts, 1):
        scalars[f"impact_{number}"] = (time, radius)
        scalars[f"impact_{number}_closing"] = (closing, 0.0)
        scalars[f"impact_{number}_body"] = (float(bodies[0]), 0.0)
        if len(bodies) > 1:
            scalars[f"impact_{number}_other"] = (float(bodies[1]), 0.0)
    return scalars


def with_list(of, *impacts, until=None, growth=None):
    """Truth of an instance that says nothing but the list of impacts."""
    return truth(
        of.times,
        {"r1.x": [0.0] * len(of.times)},
        scalars=listing(*impacts),
        until=until,
        growth=growth,
    )


@pytest.mark.parametrize(
    ("wait", "level", "dense"),
    [
        # 4 samples a wait: 4 x 1 s <= dense x wait.
        (4.0, 2.0**-12, 1),
        (3.999, 2.0**-12, 2),
        (2.0, 2.0**-12, 2),
        (0.25, 2.0**-12, 16),
        (1e-3, 2.0**-12, 64),
        # Steps of 1/8 s: no more than 8 samples in 1 s.
        (0.25, 0.125, 8),
        (0.25, 0.1251, 4),
    ],
)
def test_samples_are_so_dense_that_impacts_come_alone_as_far_as_steps_allow(wait, level, dense):
    of = sequence()
    known = with_list(of, (0.0, 0.0, 1.0, (0,)), (wait, 0.0, 1.0, (0,)))
    expected = Variant(level)
    if dense > 1:
        expected = Variant(level, "denser_output", dense)
    assert _impacts.dense_variant(Subject(of, method(), (level,), known)) == expected
    assert _impacts.dense_variant(Subject(of, method(), (level,), None)) == Variant(level)


def test_an_impact_after_the_last_sample_makes_samples_no_denser():
    of = sequence()
    last = float(of.times[-1])
    known = with_list(of, (last - 0.25, 0.0, 1.0, (0,)), (last + 0.25, 0.0, 1.0, (0,)))
    level = 2.0**-12
    assert _impacts.dense_variant(Subject(of, method(), (level,), known)) == Variant(level)


def test_windows_are_the_last_sample_before_an_impact_and_the_first_after_it():
    of = sequence()
    known = with_list(of, (0.5, 0.0, 1.0, (0,)), (1.5, 0.0, 1.0, (1,)), (2.75, 0.0, 1.0, (0, 1)))
    run = standing(of)

    def found(late):
        return [(w.first, w.last, w.late_by) for w in _impacts.windows(known, run, late)]

    assert found([0.0, 0.0, 0.0]) == [(0, 1, 0.0), (1, 2, 0.0), (2, 3, 0.0)]
    # The second may come from 1 to 2 s: the samples at these times know nothing.
    assert [
        (w.impact.time, w.first, w.last) for w in _impacts.windows(known, run, [0.0, 0.5, 0.0])
    ] == [
        (0.5, 0, 1),
        (2.75, 2, 3),
    ]
    # Of the third nothing is known but that it comes later than 2.75 s.
    assert [
        (w.impact.time, w.first, w.last) for w in _impacts.windows(known, run, [0.0, 0.25])
    ] == [
        (0.5, 0, 1),
        (1.5, 1, 2),
    ]


def test_windows_end_where_truth_does():
    of = sequence()
    known = with_list(of, (0.5, 0.0, 1.0, (0,)), (2.5, 0.0, 1.0, (1,)), until=3)
    assert [w.impact.time for w in _impacts.windows(known, standing(of), [0.0, 0.0])] == [0.5]


def of_window(bodies, first=0, last=1, late=0.0):
    """A window of the first impact of these bodies."""
    return Window(Impact(0.5, 0.0, 1.0, bodies), first, last, late)


def test_masses_of_an_impact_are_reduced_along_the_normal_and_eased_by_turning_across_it():
    bodies = _impulses.bodies_of(sequence().scene, of_window((0, 1)))
    assert bodies.normal_mass == near(2 / 3, rel=1e-14)
    # 1/2 + 1 + 1/0.8 + 0.25/0.1
    assert bodies.tangential_mass == near(1 / (1.5 + 1.25 + 2.5), rel=1e-14)
    alone = _impulses.bodies_of(sequence().scene, of_window((1,)))
    assert (alone.normal_mass, alone.tangential_mass) == (1.0, 1 / 3.5)
    stiff = _impulses.Bodies(np.array([2.0]), np.array([1.0]), np.array([0.0]))
    assert stiff.tangential_mass == 2.0


def test_a_ball_touches_a_plane_after_the_root_of_its_fall():
    of = sequence()
    # From 4 m, at 1 m/s downwards, under 2 m/s^2: 3 = t + t^2, t = (sqrt(13) - 1)/2.
    run = standing(of, position=[[[0, 0, 4.0]] * 2] * 5, velocity=[[[7.0, 0, -1.0]] * 2] * 5)
    found = _impulses.touch(of.scene, run, of_window((0,)))
    assert found.wait == near((sqrt(13) - 1) / 2, rel=1e-14)
    assert found.normal.tolist() == [0.0, 0.0, -1.0]
    # Upwards first: 3 = -t + t^2.
    up = standing(of, position=run.position, velocity=-run.velocity)
    assert _impulses.touch(of.scene, up, of_window((0,))).wait == near((sqrt(13) + 1) / 2)
    # The other one has less to go: 3.5 m.
    other = _impulses.touch(of.scene, run, of_window((1,)))
    assert other.wait == near((sqrt(15) - 1) / 2, rel=1e-14)
    # Without gravity it must go down.
    free = sequence(elements=(LAW, FLOOR))
    assert _impulses.touch(free.scene, run, of_window((0,))).wait == 3.0
    assert _impulses.touch(free.scene, up, of_window((0,))) is None


def test_of_two_planes_the_one_that_is_touched_first_counts():
    wall = Plane(point=(-2.0, 0.0, 0.0), normal=(1.0, 0.0, 0.0))
    of = sequence(elements=(LAW, FLOOR, wall))
    run = standing(of, position=[[[0, 0, 4.0]] * 2] * 5, velocity=[[[-4.0, 0, -1.0]] * 2] * 5)
    found = _impulses.touch(of.scene, run, of_window((0,)))
    assert (found.wait, found.normal.tolist()) == (0.25, [-1.0, 0.0, 0.0])


def test_two_balls_touch_where_straight_lines_bring_them_to_the_sum_of_radii():
    of = sequence()
    # Seen from the first: (3.9, 0.9, 0) going with (-5, 0, 0); the touch is at (1.2, 0.9).
    run = standing(
        of,
        position=[[[0, 0, 9.0], [3.9, 0.9, 9.0]]] * 5,
        velocity=[[[2.0, 1.0, -1.0], [-3.0, 1.0, -1.0]]] * 5,
    )
    found = _impulses.touch(of.scene, run, of_window((0, 1)))
    assert found.wait == near(2.7 / 5, rel=1e-14)
    np.testing.assert_allclose(found.normal, [0.8, 0.6, 0.0], rtol=1e-13, atol=1e-15)
    # They part, or pass each other.
    away = standing(of, position=run.position, velocity=-run.velocity)
    assert _impulses.touch(of.scene, away, of_window((0, 1))) is None
    # So do two that overlap already and move along each other: none nears the other.
    along = standing(of, position=[[[0, 0, 9.0], [0, 1.25, 9.0]]] * 5, velocity=run.velocity)
    assert _impulses.touch(of.scene, along, of_window((0, 1))) is None
    wide = standing(of, position=[[[0, 0, 9.0], [3.9, 1.6, 9.0]]] * 5, velocity=run.velocity)
    assert _impulses.touch(of.scene, wide, of_window((0, 1))) is None


def struck_floor():
    """A ball that falls 3 m from rest within 4 s, and what an impact did to it.

    It touches after sqrt(3) s at 2 sqrt(3) m/s; the window is from 0 to 2 s.
    """
    of = sequence(bodies=(BIG,))
    fell = sqrt(3.0)
    up = 0.5 * 2 * fell
    velocity = np.zeros((5, 1, 3))
    velocity[:2, 0] = [(3.0, 0, 0), (3.0, 0, -2.0)]
    velocity[2:, 0] = [(2.5, 0.0, up - 2.0 * (t - fell)) for t in (2.0, 3.0, 4.0)]
    omega = np.zeros((5, 1, 3))
    omega[:2, 0] = (0.5, 1.0, 0.25)
    omega[2:, 0] = (0.5, 2.25, 0.25)
    run = standing(of, position=[[[0, 0, 4.0]]] * 5, velocity=velocity, omega=omega)
    return of, run, _impulses.struck(of.scene, run, of_window((0,), 0, 2))


def test_an_impact_changes_velocities_less_what_gravity_did_before_and_after_it():
    _, _, found = struck_floor()
    fell = sqrt(3.0)
    assert found.closing == near(2 * fell, rel=1e-13)
    assert found.parting == near(fell, rel=1e-13)
    # v + (R omega) x n with n = -z: 3 - 1 along x, 1/2 along y.
    np.testing.assert_allclose(found.slip, [2.0, 0.5, 0.0], atol=1e-13)
    np.testing.assert_allclose(found.impulse, [-1.0, 0.0, 2 * 3 * fell], rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(found.spun, [[0.0, 1.0, 0.0]], atol=1e-14)
    spinning = sqrt(0.25 + 1.0 + 0.0625)
    assert found.fastest == near(sqrt(9 + 12) + spinning, rel=1e-13)


def test_two_balls_change_by_their_relative_speed():
    of = sequence(elements=(LAW,), bodies=(BIG, body(SMALL, position=(4.0, 1.0, 0.0))))
    velocity = np.zeros((5, 2, 3))
    velocity[0] = [(1.0, 0, 0), (-4.0, 0, 0)]
    velocity[1:] = [(-1.0, 0.5, 0), (0.0, -1.0, 0)]
    omega = np.zeros((5, 2, 3))
    omega[0] = [(0, 0, 2.0), (0, 0, 4.0)]
    omega[1:] = [(0, 0, 3.0), (0, 0, 6.0)]
    place = [[[0, 0, 0], [3.9, 0.9, 0]]] * 5
    run = standing(of, position=place, velocity=velocity, omega=omega)
    found = _impulses.struck(of.scene, run, of_window((0, 1), 0, 1))
    n = np.array([0.8, 0.6, 0.0])
    # v_12 = (5, 0, 0), (R_1 w_1 + R_2 w_2) x n = 4 z x n = (-2.4, 3.2, 0).
    approach = np.array([5.0 - 2.4, 3.2, 0.0])
    assert found.closing == near(4.0, rel=1e-13)
    np.testing.assert_allclose(found.slip, approach - 4.0 * n, atol=1e-13)
    assert found.parting == near(-np.dot([-1.0, 1.5, 0], n), rel=1e-13)
    np.testing.assert_allclose(found.impulse, [-4.0, 1.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(found.spun, [[0, 0, 0.8], [0, 0, 0.2]], atol=1e-14)
    assert found.fastest == near(5.0 + 2.0 + 2.0, rel=1e-13)
    # They touch after 0.54 s: a window that ends before has no impact.
    short = sequence(elements=(LAW,), times=(0.0, 0.5, 0.53, 0.55, 0.6))
    brief = standing(short, position=place, velocity=velocity, omega=omega)
    assert _impulses.struck(short.scene, brief, of_window((0, 1), 0, 2)) is None
    assert _impulses.struck(short.scene, brief, of_window((0, 1), 0, 3)) is not None


@pytest.mark.parametrize(
    ("control", "claims", "late"),
    [
        ("step", {}, 0.125),
        ("step", {"locates_events": True}, 0.0),
        ("exact", {}, 0.0),
        ("tolerance", {}, 0.375),
    ],
)
def test_an_impact_may_be_seen_a_step_late_or_by_the_bound_on_its_time(control, claims, late):
    subject = Subject(sequence(), method(control, **claims), (0.125,), None)
    assert _impulses.lateness(subject, of_window((0,), late=0.375)) == late


def test_what_a_speed_may_be_off_by_on_a_plane():
    of, run, found = struck_floor()
    h = 0.125
    for claims, late in (({}, h), ({"locates_events": True}, 0.0), ({"order": 1}, 2 * h)):
        subject = Subject(of, method(**claims), (h,), None)
        noise = subject.noise(h)
        speeds = 3.0 + float(np.linalg.norm(run.velocity[2, 0]))
        rounded = noise * (4.0 + 1.0)
        expected = noise * (speeds + found.fastest) + 2.0 * (late + rounded / found.closing)
        assert _impulses.off(subject, run, found, 2.0) == near(expected, rel=1e-13)


def test_what_a_speed_may_be_off_by_between_balls_is_what_the_normal_turns():
    of = sequence(elements=(LAW,), bodies=(BIG, body(SMALL, position=(4.0, 1.0, 0.0))))
    place = [[[0, 0, 0], [3.9, 0.9, 0]]] * 5
    velocity = [[(1.0, 0, 0), (-4.0, 0, 0)]] + [[(-1.0, 0, 0), (0.0, 2.0, 0)]] * 4
    run = standing(of, position=place, velocity=velocity)
    found = _impulses.struck(of.scene, run, of_window((0, 1), 0, 1))
    assert (found.closing, found.fastest) == (near(4.0), near(5.0))
    for claims, late in (({}, 2.0**-7), ({"locates_events": True}, 0.0)):
        subject = Subject(of, method(**claims), (2.0**-7,), None)
        noise = subject.noise(2.0**-7)
        rounded = noise * (sqrt(3.9**2 + 0.9**2) + 1.5)
        turned = (late * 5.0 + rounded * 5 / 4) / 1.5
        of_speeds = subject.round_off(2.0**-7) * (1 + 4 + 1 + 2 + 5.0)
        expected = of_speeds + 2 * 5.0 * turned * (1 + turned)
        assert _impulses.off(subject, run, found, 0.0) == near(expected, rel=1e-12)
    line = sequence(elements=(LAW,), bodies=(BIG, SMALL))
    subject = Subject(line, method(), (2.0**-7,), None)
    straight = standing(line, velocity=[[(1.0, 0, 0), (-4.0, 0, 0)]] * 5)
    met = _impulses.struck(line.scene, straight, of_window((0, 1), 0, 1))
    of_speeds = subject.round_off(2.0**-7) * (1 + 4 + 1 + 4 + 5.0)
    assert _impulses.off(subject, straight, met, 0.0) == near(of_speeds, rel=1e-12)


def test_gravity_has_a_part_along_a_normal_and_one_across_it():
    of, _, found = struck_floor()
    assert _impulses.pulls(of.scene, found) == (2.0, 0.0)
    slanted = sequence(bodies=(BIG,), elements=(LAW, UniformGravity(g=(3.0, 0, -4.0)), FLOOR))
    assert _impulses.pulls(slanted.scene, found) == (4.0, 3.0)


def test_a_spin_is_rounded_as_a_velocity_and_by_its_turns():
    spinning = sequence(bodies=(body(BIG, omega=(0, 0, 1.0)),))
    subject = Subject(spinning, method(), (0.125,), None)
    steps = 4 / 0.125
    expected = subject.noise(0.125) + 3 * U * steps
    assert _impulses.spin_noise(subject) == near(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("friction", "reversed_part", "size"),
    [
        # m_t s = 2/3.5... of one ball of 2 kg, J = 0.8: m_t = 1/(1/2 + 1/0.8) = 4/7 kg; |s| is
        # sqrt(4.25) m/s; mu p = mu (3/2) 2 kg 2 sqrt(3) m/s.
        (9.0, 0.0, 4 / 7 * sqrt(4.25)),
        (9.0, 0.5, 1.5 * 4 / 7 * sqrt(4.25)),
        (0.0625, 0.0, 0.0625 * 1.5 * 2 * 2 * sqrt(3.0)),
        (0.0, 0.0, 0.0),
    ],
)
def test_the_law_stops_or_reverses_the_slip_as_far_as_the_cone_lets_it(
    friction, reversed_part, size
):
    _, _, found = struck_floor()
    law = Contact(
        law="rigid", restitution=0.5, friction=friction, tangential_restitution=reversed_part
    )
    scene = sequence(bodies=(BIG,), elements=(law, FALL, FLOOR)).scene
    expected = -size * np.array([2.0, 0.5, 0.0]) / sqrt(4.25)
    np.testing.assert_allclose(_impulses.by_law(scene, found), expected, rtol=1e-12, atol=1e-15)


def test_the_restitution_of_an_impact_is_judged_in_parts_of_its_closing_speed():
    of, run, found = struck_floor()
    subject = Subject(of, method(), (2.0**-9,), with_list(of, (1.7, 0.0, 3.0, (0,))))
    departure = rigid_impact._restitution_of(subject, run, found)
    assert departure.value == pytest.approx(0.0, abs=1e-14)
    off = _impulses.off(subject, run, found, 2.0)
    assert departure.bound == near(1.5 * off / (2 * sqrt(3.0)), rel=1e-13)


def test_friction_of_an_impact_is_judged_in_units_of_mass_times_closing_speed():
    of, run, found = struck_floor()
    subject = Subject(of, method(), (2.0**-9,), with_list(of, (1.7, 0.0, 3.0, (0,))))
    departure = rigid_impact._friction_of(subject, run, found)
    unit = 2 * 2 * sqrt(3.0)
    # The run has (-1, 0, 0) N s; the law wants 4/7 kg of the slip (2, 1/2) against it.
    wanted = -4 / 7 * np.array([2.0, 0.5, 0.0])
    assert np.linalg.norm(wanted) < 0.25 * 1.5 * unit
    value = np.linalg.norm(np.array([-1.0, 0, 0]) - wanted) / unit
    assert departure.value == near(value, rel=1e-12)
    carried = 4 / 7 + 0.25 * 1.5 * 2
    along = _impulses.off(subject, run, found, 2.0)
    across = _impulses.off(subject, run, found, 0.0)
    spinning = _impulses.spin_noise(subject) * found.fastest
    bound = (carried * (along + spinning) + 2 * 2 * across) / unit
    assert departure.bound == near(bound, rel=1e-12)
    springy = Contact(law="rigid", restitution=0.5, friction=0.25, tangential_restitution=0.25)
    again = sequence(bodies=(BIG,), elements=(springy, FALL, FLOOR))
    other = Subject(again, method(), (2.0**-9,), with_list(again, (1.7, 0.0, 3.0, (0,))))
    carried = 1.25 * 4 / 7 + 0.25 * 1.5 * 2
    bound = (carried * (along + spinning) + 2 * 2 * across) / unit
    assert rigid_impact._friction_of(other, run, found).bound == near(bound, rel=1e-12)


def test_spins_of_an_impact_are_judged_by_the_moment_of_the_impulse_that_is_seen():
    of, run, found = struck_floor()
    subject = Subject(of, method(), (2.0**-9,), with_list(of, (1.7, 0.0, 3.0, (0,))))
    departure = rigid_impact._spin_of(subject, run, found)
    unit = 2 * 2 * sqrt(3.0)
    # R n x P with n = -z and P = (-1, 0, p): (0, 1, 0); J dw = (0, 1, 0).
    assert departure.value == pytest.approx(0.0, abs=1e-14)
    omega = sqrt(0.25 + 1 + 0.0625) + sqrt(0.25 + 2.25**2 + 0.0625)
    rounded = _impulses.spin_noise(subject) * 0.8 * omega / unit
    speeds = 2 * 2 * _impulses.off(subject, run, found, 0.0)
    assert departure.bound == near(rounded + speeds / unit, rel=1e-12)
    assert rigid_impact.Departure(3.0, 4.0, "").share == 0.75


def test_spins_of_balls_are_judged_in_units_of_their_own_radii():
    first = body(BIG, velocity=(4.0, 0, 0))
    second = body(SMALL, position=(2.5, 0.0, 0.0))
    of = instance([first, second], (LAW,), times=TIMES, quantities={"r1.x": 4.0, "r2.x": 4.0})
    velocity = np.zeros((5, 2, 3))
    velocity[0, 0] = (4.0, 0, 0)
    velocity[1:] = [(2.0, -0.5, 0), (4.0, 1.0, 0)]
    omega = np.zeros((5, 2, 3))
    omega[1:, :, 2] = (1.0, 5.0)
    run = standing(of, velocity=velocity, omega=omega)
    found = _impulses.struck(of.scene, run, of_window((0, 1), 0, 1))
    known = with_list(of, (0.25, 0.0, 4.0, (0, 1)))
    subject = Subject(of, method(), (2.0**-9,), known)
    departure = rigid_impact._spin_of(subject, run, found)
    # The unit is 2/3 kg x 4 m/s x R; P = (-4, -1, 0), n = x: R n x P is -R along z for both.
    unit = 2 / 3 * 4.0
    gained = (0.8 * 1.0, 0.1 * 5.0)
    values = [
        abs(gain - -radius) / (unit * radius)
        for gain, radius in zip(gained, (1.0, 0.5), strict=True)
    ]
    assert departure.value == near(max(values), rel=1e-12)
    noise = _impulses.spin_noise(subject)
    rounded = noise * max(0.8 * 1.0 / unit, 0.1 * 5.0 / (unit * 0.5))
    speeds = 2 * 2.0 * _impulses.off(subject, run, found, 0.0)
    assert departure.bound == near(rounded + speeds / unit, rel=1e-12)


def one_impact(
    *,
    law=LAW,
    parting=0.5,
    across=0.0,
    plane=True,
    level=2.0**-9,
    gap=1.0,
    control="step",
    **claims,
):
    """Findings on one impact: of a ball of 2 kg on a floor, or of two balls, at 4 m/s."""
    if plane:
        ball = body(BIG, position=(0, 0, 1.0 + gap), velocity=(0, 0, -4.0))
        of = instance([ball], (law, FLOOR), times=TIMES)
        after = [[(across, 0.0, parting * 4.0)]]
    else:
        first = body(BIG, position=(-2.0, 1.0, 0.0), velocity=(4.0, 0, 0))
        second = body(SMALL, position=(gap - 0.5, 1.0, 0.0), velocity=(0.0, 0.0, 0.0))
        of = instance([first, second], (law,), times=TIMES)
        # p = 2/3 kg x 4 m/s x (1 + e)
        impulse = 8 / 3 * (1 + parting)
        after = [[(4 - impulse / 2, -across / 2, 0.0), (impulse, across, 0.0)]]
    velocity = np.array([of.scene.bodies.velocity.tolist(), *(after * 4)])
    run = standing(of, velocity=velocity)
    subject = Subject(of, method(control, **claims), (level,), None)
    return subject, findings(RIGID_IMPACT, subject, run)


def test_the_restitution_of_one_impact_is_held_to_round_off_on_a_plane():
    subject, found = one_impact(parting=0.5625, across=1.0)
    noise = subject.noise(2.0**-9)
    restitution = found["restitution"]
    assert restitution.value == near(0.0625, rel=1e-13)
    off = noise * (4.0 + sqrt(1 + 2.25**2))
    assert restitution.bound == near(off / 4.0, rel=1e-13)
    assert restitution.sharpness == near(off / 4.0 / 1.5, rel=1e-13)
    # p_t = 2 x 1, p_n = 2 x 4 x 25/16; the unit is 2 kg x 8 m/s.
    cone = found["cone"]
    assert cone.value == 0.0
    assert cone.bound == near(off / 8.0 * 1.25, rel=1e-13)
    _, beyond = one_impact(parting=0.5, across=4.0)
    assert beyond["cone"].value == near((2 * 4.0 - 0.25 * 2 * 6.0) / 16, rel=1e-13)


def test_one_impact_of_balls_may_be_off_by_what_the_normal_turns_in_a_step():
    for claims, turned in (({}, 2.0**-9 * 4.0 / 1.5), ({"locates_events": True}, 0.0)):
        subject, found = one_impact(plane=False, **claims)
        noise = subject.noise(2.0**-9)
        speeds = 4.0 + 2.0 + 4.0
        off = 4 * 4.0 * turned * (1 + turned) + noise * speeds
        assert found["restitution"].value == pytest.approx(0.0, abs=1e-14)
        assert found["restitution"].bound == near(off / 4.0, rel=1e-12)
        assert found["cone"].bound == near(off / 8.0 * 1.25, rel=1e-12)
    _, coarse = one_impact(plane=False, level=2.0**-5)
    assert coarse["restitution"].outcome == "undecided"
    assert "the normal may turn so far within a step" in coarse["restitution"].sentence


def test_the_speeds_of_an_impact_are_those_of_the_first_and_the_last_sample():
    ball = body(BIG, position=(0, 0, 7.0), velocity=(0, 0, -4.0))
    of = instance([ball], (LAW, FLOOR), times=TIMES)
    # It falls 6 m in 3/2 s, and leaves with 2 m/s.
    velocity = np.array([[(0, 0, -4.0)]] * 2 + [[(0, 0, 2.0)]] * 3)
    subject = Subject(of, method(), (2.0**-9,), None)
    found = findings(RIGID_IMPACT, subject, standing(of, velocity=velocity))["restitution"]
    assert found.value == 0.0
    assert found.bound == near(subject.noise(2.0**-9) * 6.0 / 4.0, rel=1e-13)


def lying(
    height=1.0, velocity=(3.0, 0, 0), law=LAW, elements=(FALL,), radius=1.0, normal=(0, 0, 1.0)
):
    """True if a ball at this height over a floor lies on it."""
    ball = Body(
        mass=2.0,
        inertia=(0.8,) * 3,
        position=(0, 0, height),
        velocity=velocity,
        shape=Sphere(radius=radius),
    )
    return _sphere_on_plane.starts_on_plane(
        instance([ball], (law, Plane(normal=normal), *elements)).scene
    )


def test_a_ball_lies_that_touches_does_not_move_across_and_is_pressed():
    assert lying()
    assert lying(velocity=(0.0, 0, 0))
    assert lying(height=1 + 0.9e-12)
    assert not lying(height=1 + 1.1e-12)
    assert not lying(height=-1.0)
    assert lying(velocity=(3.0, 0, 2.9e-12))
    assert not lying(velocity=(3.0, 0, 3.1e-12))
    assert not lying(elements=(UniformGravity(g=(0, 0, 2.0)),))
    assert not lying(elements=(UniformGravity(g=(2.0, 0, 0)),))
    assert not lying(elements=())
    assert not lying(law=Contact(law="linear", stiffness=1.0))


def test_slip_moment_and_weight_of_a_ball_that_lies():
    ball = body(BIG, velocity=(3.0, 0, 0), omega=(0, 1.0, 0.5), position=(0, 0, 1.0))
    gravity = UniformGravity(g=(1.5, 0, -10.0))
    scene = instance([ball], (LAW, FLOOR, gravity)).scene
    slip, rate = _sphere_on_plane.slip_at_start(scene)
    # v - R w x n = 3 - 1; g_t - mu g_n (1 + m R^2/J) = 1.5 - 10/4 (1 + 2/0.8).
    np.testing.assert_allclose(slip, [2.0, 0, 0], atol=1e-15)
    np.testing.assert_allclose(rate, [1.5 - 2.5 * 3.5, 0, 0], atol=1e-14)
    rolling = body(BIG, velocity=(1.0, 0, 0), omega=(0, 1.0, 0), position=(0, 0, 1.0))
    slip, rate = _sphere_on_plane.slip_at_start(instance([rolling], (LAW, FLOOR, gravity)).scene)
    assert slip.tolist() == [0.0, 0.0, 0.0]
    assert rate.tolist() == [1.5, 0.0, 0.0]
    moment = _sphere_on_plane.moment(scene, np.array([[3.0, 4.0, 0]]), np.array([[0.5, 1.0, 9.0]]))
    # R n x m v = 2 (-4, 3, 0); J w across is 0.8 (1/2, 1, 0).
    np.testing.assert_allclose(moment, [[-8 + 0.4, 6 + 0.8, 0]], atol=1e-14)
    np.testing.assert_allclose(_sphere_on_plane.moment_of_gravity(scene), [0, 3.0, 0], atol=1e-14)


def test_an_impact_after_the_last_sample_is_not_due():
    assert one_impact(gap=15.9)[1]["restitution"].outcome == "pass"
    for gap in (16.0, 17.0):
        assert "no impact is due" in one_impact(gap=gap)[1]["restitution"].sentence
    assert one_impact(gap=15.9, plane=False)[1]["restitution"].outcome == "pass"
    assert "no impact is due" in one_impact(gap=16.1, plane=False)[1]["restitution"].sentence


def test_surfaces_that_spin_meet_faster():
    first = body(BIG, velocity=(3.0, 0, 4.0), omega=(0, 2.0, 0))
    second = body(SMALL, omega=(0, 0, -4.0), velocity=(0.0, 0, 4.0))
    assert rigid_impact._fastest(instance([first, second], (LAW,)).scene) == 3.0 + 2.0 + 2.0
    assert rigid_impact._fastest(instance([first], (LAW, FLOOR)).scene) == 5.0 + 2.0


def test_balls_that_nearly_pass_each_other_turn_their_normal_by_more():
    first = body(BIG, velocity=(5.0, 0, 0))
    second = body(SMALL, position=(3.9, 1.2, 0.0))
    of = instance([first, second], (LAW,), times=TIMES)
    velocity = np.array([[(5.0, 0, 0), (0, 0, 0)]] * 5)
    # The touch is where y = 1.2 is 4/5 of 1.5 m: n = (0.6, 0.8), closing at 3 m/s; an impulse of
    # (1 + e) 2/3 kg 3 m/s along it.
    impulse = 1.5 * 2 / 3 * 3.0 * np.array([0.6, 0.8, 0.0])
    velocity[1:, 0] -= impulse / 2.0
    velocity[1:, 1] += impulse
    run = standing(of, velocity=velocity)
    subject = Subject(of, method(locates_events=True), (2.0**-9,), None)
    found = findings(RIGID_IMPACT, subject, run)["restitution"]
    speeds = 5.0 + float(np.linalg.norm(velocity[1], axis=-1).sum())
    assert found.value == pytest.approx(0.0, abs=1e-13)
    expected = subject.noise(2.0**-9) * speeds * (5 / 3) / 3.0
    assert found.bound == near(expected, rel=1e-12)


def test_momentum_of_a_pair_is_held_to_round_off_in_units_of_its_impulse():
    of = sequence(elements=(LAW,), bodies=(BIG, SMALL), quantities={"r1.x": 4.0, "r2.x": 4.0})
    velocity = np.zeros((5, 2, 3))
    velocity[:1] = [(4.0, 0, 0), (0, 0, 0)]
    velocity[1:] = [(2.0, 0, 0), (4.5, 0, 0)]
    run = standing(of, velocity=velocity)
    known = truth(
        TIMES, {"r1.x": [0.0] * 5, "r2.x": [4.0] * 5}, scalars=listing((0.625, 0.0, 4.0, (0, 1)))
    )
    subject = Subject(of, method(), (2.0**-9,), known)
    found = {f.quantity: f for f in momentum._of_pairs(subject, run, run)}["pairs"]
    exchanged = 1.5 * 2 / 3 * 4.0
    assert found.value == near(0.5 / exchanged, rel=1e-13)
    momenta = 8.0 + 0.0 + 4.0 + 4.5
    assert found.bound == near(subject.round_off(2.0**-9) * momenta / exchanged, rel=1e-13)


def test_total_momentum_is_held_to_round_off_in_units_of_all_momenta():
    first = body(BIG, velocity=(3.0, 0, 0))
    second = body(SMALL, velocity=(0.0, -4.0, 0))
    of = instance([first, second], (Contact(law="linear", stiffness=1.0),), times=TIMES)
    velocity = np.repeat(of.scene.bodies.velocity[None], 5, axis=0)
    velocity[2, 0] += (3.0, 4.0, 0.0)
    subject = Subject(of, method(), (2.0**-6, 2.0**-7), None)
    found = findings(MOMENTUM, subject, standing(of, velocity=velocity))["total"]
    # |dp| = 2 x 5 kg m/s; m |v| = 6 + 4.
    assert (found.value, found.sharpness) == (1.0, near(found.bound / 1.0))
    assert found.bound == near(8 * U * 16, rel=1e-14)
    still = findings(MOMENTUM, subject, standing(of))["total"]
    assert (still.value, still.sharpness) == (0.0, None)


def test_velocities_in_flight_change_by_g_t_and_round_off():
    of = sequence(bodies=(BIG,), quantities={"r1.z": 4.0})
    # The impact may come from 1.25 to 1.75 s: the second interval is no flight.
    velocity = np.zeros((5, 1, 3))
    velocity[:, 0, 2] = (0.0, -2.0, 5.0, 3.0, 1.5)
    run = standing(of, velocity=velocity)
    known = truth(TIMES, {"r1.z": [0.0] * 5}, scalars=listing((1.5, 0.25, 3.0, (0,))))
    subject = Subject(of, method(), (2.0**-9,), known)
    found = momentum._in_flights(subject, run)
    assert found.value == near(0.5 / 8, rel=1e-14)
    assert found.bound == near(subject.noise(2.0**-9), rel=1e-14)
    assert found.sharpness == near(found.bound / (2.0 / 8), rel=1e-14)
