"""Every part of a bound is the number that its formula gives: a bound that is wider by a half would
miss faults, and is seen here.

Scales are L = 4 m, tau = 1/2 s, T = 8 s, so that T/tau = 16.
"""

from math import sqrt

import numpy as np
import pytest

from refdem.core import refinement
from refdem.core.check import Subject
from refdem.core.quantity import Scales
from refdem.core.refinement import (
    clock,
    flight,
    levels,
    of_alternating_friction,
    of_directions,
    of_far_places,
    of_rods,
    order,
    round_off,
    scored,
    smoothness,
    start_acceleration,
    steps_at,
    sweeping,
    truncation,
    turning,
)
from refdem.errors import UsageError
from refdem.scene import Body, Sphere
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.handmade import U, instance, method, near, truth

POINT = Body(mass=2.0, position=(1.0, 0.0, 0.0))
SPHERE = Body(mass=1.0, inertia=(0.1, 0.1, 0.1), shape=Sphere(radius=0.5))
SPRING = Spring(a=0, b=-1, stiffness=3.0)
SINGLE = 2.0**-24


@pytest.mark.parametrize(
    ("steps", "factor"), [(0.25, 16.0), (256.0, 16.0), (257.0, sqrt(257.0)), (1e4, 100.0)]
)
def test_round_off_is_eight_roundings_times_the_root_of_the_steps_or_the_phase(steps, factor):
    assert round_off(instance([POINT]), method(), steps) == near(8 * U * factor, rel=1e-14)


def test_round_off_is_eight_roundings_at_least():
    brief = instance([POINT], scales=Scales(4.0, 8.0, 2.0))
    assert round_off(brief, method(), 0.25) == 8 * U


@pytest.mark.parametrize("height", [0.5, 0.01])
def test_rods_that_hardly_fix_a_body_round_it_by_so_much_more(height):
    # Two rods of length l from the world at (+-1, -height) meet in a body: lengths that are both
    # off by s lift it by s l/height, in units of L = 4.
    length = sqrt(1 + height**2)
    rods = tuple(Rod(a=0, length=length, anchor_b=(x, -height, 0.0)) for x in (1.0, -1.0))
    held = instance([Body(mass=2.0)], rods)
    assert of_rods(held) == near(length**2 / height / 4.0)
    assert round_off(held, method(), 1) == near(max(8.0, of_rods(held)) * U * 16.0)
    assert of_rods(instance([POINT], (SPRING,))) == 0.0


def test_differences_of_places_round_velocities_by_tau_over_h():
    # 1000 steps in T = 16 tau are 125/2 of tau/h.
    differenced = method(differenced_velocities=True)
    point = instance([POINT])
    assert round_off(point, differenced, 1000) == near(62.5 * round_off(point, method(), 1000))
    coarse = round_off(point, method(), 8)
    assert round_off(point, differenced, 8) == coarse
    exact = method("exact", differenced_velocities=True)
    assert round_off(point, exact, 1000) == round_off(point, method(), 1000)
    far = instance([Body(mass=2.0, position=(4000.0, 0.0, 0.0))])
    plain = of_far_places(far, method(), 8e-3)
    assert of_far_places(far, differenced, 8e-3) == near(62.5 * plain)
    # L is 4: a place at 4000 is rounded a thousand times as much, and so is what differs over h.
    assert round_off(far, differenced, 1000) == near(62500 * round_off(far, method(), 1000))


def test_places_far_away_are_rounded_by_their_distance():
    bodies = [POINT, Body(mass=1.0, position=(0.0, -12.0, 5.0))]
    free = instance(bodies)
    sprung = instance(bodies, (SPRING,))
    assert of_far_places(free, method("exact"), 0.0) == 8 * U * 3
    assert of_far_places(free, method("tolerance"), 1e-6) == 8 * U * 3
    # One step rounds as any number; of 512 steps roundings scatter, or are alike in free flight.
    assert of_far_places(sprung, method(), 8.0) == 8 * U * 3
    assert of_far_places(sprung, method(), 1 / 64) == near(sqrt(6 * 512) * U * 3, rel=1e-14)
    assert of_far_places(free, method(), 1 / 64) == 512 * U * 3
    # The angle of a rod of 1/4 m is known to the rounding of its ends over its length.
    held = instance(bodies, (Rod(a=0, b=1, length=0.25),))
    assert of_far_places(held, method("exact"), 0.0) == 8 * U * 12 / 0.25


def test_terms_that_are_nearly_equal_are_rounded_alike():
    # A pendulum of l = 12 m in single precision, at 3 rad/s and 45 degrees: in polar coordinates
    # a_r = -l w^2 = -108, a_t = -g sin 45 = -8.
    root = sqrt(0.5)
    bob = Body(mass=2.0, position=(12 * root, -12 * root, 0), velocity=(36 * root, 36 * root, 0))
    hanging = (Rod(a=0, length=12.0), UniformGravity(g=(0.0, -8 / root, 0.0)))
    pendulum = instance([bob], hanging)
    acceleration = sqrt(108.0**2 + 8.0**2)
    assert start_acceleration(pendulum) == near(acceleration)
    assert start_acceleration(instance([bob], (SPRING,))) == 16.0
    # A rod between two bodies that turn about each other at 2 rad/s: 4 s^-2 times 3 m and 1 m.
    pair = [
        Body(mass=1.0, position=(3.0, 0.0, 0.0), velocity=(0.0, 6.0, 0.0)),
        Body(mass=3.0, position=(-1.0, 0.0, 0.0), velocity=(0.0, -2.0, 0.0)),
    ]
    assert start_acceleration(instance(pair, (Rod(a=0, b=1, length=4.0),))) == near(12.0)
    single = method(precision="single")
    # Steps that change by k spacings in all: rounded alike n times if k < 1, n/k times if not.
    far = 12 * root * SINGLE / 4
    for step in (2.0**-22, 2.0**-30):
        steps = 8 / step
        spacings = step * acceleration * 8 / (2 * 12 * root * SINGLE)
        scattered = sqrt(6 * steps)
        alike = 2 * steps / max(1.0, spacings)
        assert alike > scattered
        assert of_far_places(pendulum, single, step) == near(alike * far)
    assert of_far_places(pendulum, single, 1 / 64) == near(sqrt(6 * 512) * far)


def test_a_run_resolves_no_more_than_far_places_show():
    of = instance([Body(mass=1.0, position=(12.0, 0.0, 0.0))])
    far = Subject(of, method(), (1 / 64,), None)
    assert far.resolution(1 / 64) == 512 * U * 3
    assert far.noise(1 / 64) == near(8 * U * sqrt(512) + 512 * U, rel=1e-14)
    # As far as the scale, places are rounded by less than all that a step rounds.
    near_by = Subject(
        instance([Body(mass=1.0, position=(4.0, 0.0, 0.0))]), method(), (1 / 64,), None
    )
    assert near_by.resolution(1 / 64) == near_by.noise(1 / 64)


@pytest.mark.parametrize(
    ("bodies", "rods", "control", "factor"),
    [
        (2, 2, "step", sqrt(53 * 2 * 2 / 2 / 10)),
        (3, 2, "step", sqrt(53 * 2 * 2 / 3 / 10)),
        (1, 1, "step", 1.0),
        (2, 2, "exact", 1.0),
        (2, 2, "tolerance", 1.0),
    ],
)
def test_rods_that_share_bodies_are_swept_over_once_a_bit(bodies, rods, control, factor):
    points = [Body(mass=1.0, position=(float(k), 0.0, 0.0)) for k in range(bodies)]
    joined = tuple(
        Rod(a=k, b=k - 1, length=1.0, anchor_b=(-1.0 * (k == 0), 0, 0)) for k in range(rods)
    )
    chain = instance(points, joined)
    assert sweeping(chain, method(control)) == near(factor, rel=1e-14)


def test_few_sweeps_over_many_bodies_are_no_factor():
    points = [Body(mass=1.0, position=(float(k), 0.0, 0.0)) for k in range(12)]
    rods = (Rod(a=1, b=0, length=1.0), Rod(a=2, b=1, length=1.0))
    assert sweeping(instance(points, rods), method(precision="single")) == 1.0


@pytest.mark.parametrize(
    ("bodies", "elements", "repeats"),
    [
        ([POINT], (), True),
        ([POINT], (UniformGravity(g=(0, 0, -1)),), True),
        ([SPHERE], (Contact(law="linear", stiffness=1.0), Plane()), True),
        ([POINT], (SPRING,), False),
        ([POINT], (SPRING, UniformGravity(g=(0, 0, -1))), False),
        ([POINT], (SPRING, Slider(a=0, axis=(1, 0, 0), friction=0.1, normal_force=1.0)), True),
        ([POINT], (Drag(a=0, b=-1, coefficient=1.0),), False),
        ([POINT], (Drag(a=0, b=-1, coefficient=1.0), UniformGravity(g=(0, 0, -1))), True),
    ],
)
def test_equal_terms_are_rounded_once_a_step(bodies, elements, repeats):
    of = instance(bodies, elements)
    assert flight(of, method(), 1 / 64) == 512 * U * repeats
    assert flight(of, method("exact"), 0.0) == 0.0
    assert flight(of, method("tolerance"), 1e-6) == 0.0


def test_a_turn_stretches_by_three_roundings_a_step():
    spinning = instance([Body(mass=1.0, inertia=(0.1, 0.1, 0.1), omega=(0.0, 0.0, 1.0))])
    assert turning(spinning, method(), 1 / 64) == 3 * 512 * U
    assert turning(instance([POINT]), method(), 1 / 64) == 0.0
    assert turning(spinning, method("tolerance"), 1e-6) == 0.0


def test_a_clock_is_summed_once_a_sample_and_four_times_in_tau_or_once_a_step():
    summed = method("tolerance", summed_clock=True)
    assert clock(instance([POINT]), summed, 1e-6) == U * 16 * (5 + 4 * 16)
    driven = instance([POINT], (Force(a=0, amplitude=1.0, frequency=1.0),))
    assert clock(driven, method(summed_clock=True), 1 / 64) == U * 16 * 512
    assert clock(driven, method(), 1 / 64) == 0.0
    assert clock(instance([POINT], (SPRING,)), method(summed_clock=True), 1 / 64) == 0.0


def test_steps_are_those_of_the_whole_run_and_else_one_a_sample():
    assert steps_at(instance([POINT]), method(), 1 / 64) == 512
    assert steps_at(instance([POINT]), method("exact"), 0.0) == 5
    assert steps_at(instance([POINT]), method("tolerance"), 1e-6) == 5


def test_truncation_grows_from_c_with_time_and_falls_with_the_order():
    times = np.array([2.0, 3.0, 6.0])
    # C (1 + t/tau) (h/tau)^p with C = 3, p = 2, h/tau = 1/8.
    found = truncation(instance([POINT]), method(constant=3.0), 1 / 16, times)
    np.testing.assert_allclose(found, [3 / 64, 9 / 64, 27 / 64], rtol=1e-15)
    backward = truncation(instance([POINT]), method(constant=3.0), 1 / 16, times[::-1].copy())
    np.testing.assert_allclose(backward, [3 / 64, 21 / 64, 27 / 64], rtol=1e-15)
    assert not truncation(instance([POINT]), method("exact"), 0.0, times).any()


def test_a_tolerance_adds_up_to_a_thousand_of_itself_and_its_constant_is_for_smooth_motions():
    times = np.arange(3.0)
    smooth = truncation(instance([POINT]), method("tolerance", constant=0.25), 1e-7, times)
    np.testing.assert_allclose(smooth, [0.25e-4] * 3, rtol=1e-14)
    touching = instance([SPHERE], (Contact(law="linear", stiffness=1.0), Plane()))
    kinked = truncation(touching, method("tolerance", constant=0.25), 1e-7, times)
    np.testing.assert_allclose(kinked, [1e-4] * 3, rtol=1e-14)


def test_the_bound_adds_up_all_parts_and_grows_with_the_largest_growth_so_far():
    free = instance([Body(mass=1.0, position=(40.0, 0.0, 0.0))])
    stepped = method(constant=2.0)
    h = 2.0**-20
    steps = 8 / h
    known = truth([0, 2, 4], {"x": [0, 0, 0]}, growth=[1.0, 5.0, 3.0])
    # Far places, 10 L away, are rounded alike by n steps: 10 u n against 8 u sqrt(n) + u n.
    of_steps = 10 * U * steps
    truncated = 2.0 * np.array([1.0, 5.0, 9.0]) * (2 * h) ** 2
    found = refinement.bound(free, stepped, h, known)
    np.testing.assert_allclose(found, (truncated + of_steps) * [1.0, 5.0, 5.0], rtol=1e-14)
    np.testing.assert_allclose(Subject(free, stepped, (h,), known).bound(h), found, rtol=0)


def test_far_places_and_a_clock_count_in_the_bound():
    far = instance([Body(mass=1.0, position=(4000.0, 0.0, 0.0))], (SPRING,))
    known = truth([0, 2], {"x": [0, 0]}, growth=[0.5, 0.25])
    summed = method("tolerance", summed_clock=True)
    of_clock = U * 16 * (5 + 4 * 16)
    expected = 1e-6 + 8 * U * 1000 + of_clock
    np.testing.assert_allclose(
        refinement.bound(far, summed, 1e-9, known), [expected] * 2, rtol=1e-14
    )


def test_the_noise_of_a_run_is_its_round_off_and_its_repeated_sums():
    free = Subject(instance([POINT]), method(), (1 / 64,), None)
    assert free.noise(1 / 64) == near(8 * U * sqrt(512) + 512 * U, rel=1e-14)
    ticking = Subject(instance([POINT]), method("tolerance", summed_clock=True), (1e-6,), None)
    assert ticking.noise(1e-6) == near(8 * U * 16 + U * 16 * 69, rel=1e-14)


def test_what_is_kept_is_held_to_round_off_and_what_is_not_to_the_order_beside_it():
    of = instance([POINT])
    claims = method(conserves=frozenset({"energy"}))
    allowed, _ = Subject(of, claims, (1 / 64,), None).kept("energy", 1 / 64)
    np.testing.assert_allclose(allowed, [8 * U * sqrt(512)] * 5, rtol=1e-14)
    wider, _ = Subject(of, claims, (1 / 64,), None).kept("momentum", 1 / 64)
    truncated = np.array([1.0, 5.0, 9.0, 13.0, 17.0]) / 32**2
    np.testing.assert_allclose(wider, truncated + 8 * U * sqrt(512), rtol=1e-14)


def test_a_run_is_scored_up_to_a_tenth_of_the_scale_and_a_tenth_counts():
    assert scored(np.array([0.01, 0.1, 0.1])) == 3
    assert scored(np.array([0.01, 0.1000001, 0.01])) == 1
    assert scored(np.array([0.2])) == 0


DAMPED = Contact(law="linear", stiffness=1.0, damping=0.1)
HERTZ = Contact(law="hertz", stiffness=1.0)
RUBBING = Contact(law="linear", stiffness=1.0, friction=0.5)
SPRUNG = Contact(law="linear", stiffness=1.0, friction=0.5, tangential_stiffness=0.25)


@pytest.mark.parametrize(
    ("elements", "exponent", "feature"),
    [
        ((DAMPED, Plane()), 0.0, "contact:damping"),
        ((Contact(law="rigid"), Plane()), 0.0, "contact:rigid"),
        ((RUBBING, Plane()), 0.0, "contact:friction"),
        ((SPRUNG, Plane()), 1.0, "contact:friction"),
        ((HERTZ, Plane()), 1.5, "contact"),
        ((Contact(law="linear", stiffness=1.0), Plane()), 1.0, "contact"),
        ((Slider(a=0, axis=(1, 0, 0), friction=0.1, normal_force=1.0),), 0.0, "friction"),
        ((Catch(a=0, b=-1, radius=1.0),), 0.0, "catch"),
        ((Drag(a=0, b=-1, coefficient=1.0),), 2.0, "drag"),
        ((PiecewiseField(k1=1.0, k2=-1.0, x1=-1.0, x2=1.0),), 1.0, "piecewise_field"),
        ((Spring(a=0, b=-1, stiffness=1.0, exponent=1.25),), 1.25, "spring:exponent"),
        ((Spring(a=0, b=-1, stiffness=1.0, exponent=2.0),), 2.0, "spring:exponent"),
        ((Spring(a=0, b=-1, stiffness=1.0, exponent=3.0),), None, ""),
        ((Spring(a=0, b=-1, stiffness=1.0),), None, ""),
        ((Spring(a=0, b=-1, stiffness=0.0, exponent=2.0),), None, ""),
    ],
)
def test_a_singular_force_limits_the_order_by_its_exponent_and_jumps_are_left_to_the_author(
    elements, exponent, feature
):
    of = instance([SPHERE], elements)
    found = [limit for _, limit in of.scene.singularities()]
    if exponent is None:
        assert found == []
        return
    assert found == [(exponent, feature)]
    assert found[0].order == exponent + 1
    fourth = method(order=4)
    is_limited = exponent > 0
    assert order(of, fourth) == (exponent + 1 if is_limited else 4)
    assert (smoothness(of, fourth) is not None) == is_limited
    assert order(of, method(order=4, locates_events=True)) == 4
    assert order(of, method(order=4, order_with={feature: 3})) == 3
    assert order(of, method("tolerance")) == 0


def test_a_claim_below_what_a_force_allows_stands():
    of = instance([SPHERE], (HERTZ, Plane()))
    assert order(of, method(order=2)) == 2
    assert order(of, method(order=3)) == 2.5
    # A linear contact allows the second order: the claim is told as it was made, and not as 2.0.
    linear = instance([SPHERE], (Contact(law="linear", stiffness=1.0), Plane()))
    assert str(order(linear, method(order=2))) == "2"


def test_tolerances_fall_by_hundreds_down_to_twenty_roundings():
    of = instance([POINT])
    assert levels(of, method("tolerance"), 4, 1e6) == near((1e-4, 1e-6, 1e-8, 1e-10))
    assert levels(of, method("tolerance", precision="single"), 4, 1e6) == near((1e-4,))
    assert levels(of, method("tolerance"), 9, 1e6) == near((1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14))
    assert levels(of, method("exact"), 4, 1e6) == (0.0,)


def test_the_first_step_is_the_first_halving_whose_bound_is_a_tenth():
    # h <= tau (tau/(10 C T))^(1/p) = 1/2 (1/160)^(1/2) = 0.0395 s: 2 s halved six times.
    assert levels(instance([POINT]), method(), 3, 1e6) == (1 / 32, 1 / 64, 1 / 128)
    # Four times the constant, half the step.
    assert levels(instance([POINT]), method(constant=4.0), 1, 1e6) == (1 / 64,)
    # Where the target is a halving itself it is taken: 1/2 (1/16)^(1/1) = 1/32.
    scales = Scales(1.0, 0.5, 0.5)
    dyadic = instance([POINT], times=(0.0, 0.25, 0.5), scales=scales)
    assert levels(dyadic, method(order=1, constant=1.6), 1, 1e6) == (1 / 32,)
    assert levels(dyadic, method(order=1, constant=1.601), 1, 1e6) == (1 / 64,)


def test_a_given_step_is_taken_or_halved_into_the_samples():
    of = instance([POINT])
    assert levels(of, method(), 2, 1e6, 0.5) == (0.5, 0.25)
    assert levels(of, method(), 2, 1e6, 0.4) == (0.25, 0.125)
    assert levels(of, method(), 2, 1e6, 5.0) == (2.0, 1.0)
    assert levels(of, method(), 2, 1e12, 8 / 1e10) == (2.0**-31, 2.0**-32)
    with pytest.raises(UsageError, match="makes 1e"):
        levels(of, method(), 2, 1e12, 7.9 / 1e10)


def test_levels_end_at_the_most_steps_and_at_round_off():
    of = instance([POINT])
    assert levels(of, method(), 9, 1024) == (1 / 32, 1 / 64, 1 / 128)
    assert levels(of, method(), 9, 1023) == (1 / 32, 1 / 64)
    # The bound on truncation, 16 (2 h)^8, falls below 20 x 8 u sqrt(n) from h = 2^-8 on.
    eighth = levels(of, method(order=8), 9, 1e6)
    assert eighth[0] == 0.25
    for h in eighth[3:]:
        assert 16 * (2 * h) ** 8 >= 20 * round_off(of, method(), 8 / h)
    last = eighth[-1] / 2
    assert 16 * (2 * last) ** 8 < 20 * round_off(of, method(), 8 / last)
    # Three levels are an order, however small their bounds.
    assert len(levels(of, method(order=40), 9, 1e6)) == 3


def test_a_motion_that_no_affordable_step_resolves_has_no_levels():
    of = instance([POINT])
    assert levels(of, method(), 2, 15) == ()
    assert levels(of, method(), 2, 16)[0] == 0.5


def spinning(inertia, omega):
    """A body that spins about a direction in its own axes, which are those of space."""
    return instance([POINT, Body(mass=1.0, inertia=inertia, omega=omega)])


@pytest.mark.parametrize(
    ("inertia", "omega", "factor"),
    [
        # |L|/(I_min omega): 60 x 1/(2 x 1); of a spin about the slender axis it is 1.
        ((2.0, 60.0, 60.0), (0.0, 3.0, 0.0), 30.0),
        ((2.0, 60.0, 60.0), (3.0, 0.0, 0.0), 1.0),
        ((2.0, 60.0, 60.0), (4.0, 0.0, 3.0), sqrt(8.0**2 + 180.0**2) / (2.0 * 5.0)),
        ((2.0, 60.0, 60.0), (0.0, 0.0, 0.0), 0.0),
        ((0.0, 60.0, 60.0), (0.0, 3.0, 0.0), 0.0),
    ],
)
def test_a_rounding_of_an_attitude_is_more_of_the_spin_of_a_slender_body(inertia, omega, factor):
    assert of_directions(spinning(inertia, omega)) == near(factor, rel=1e-14)


def test_round_off_of_a_slender_body_that_spins_is_that_of_its_attitude():
    slender = spinning((2.0, 60.0, 60.0), (0.0, 3.0, 0.0))
    assert round_off(slender, method(), 1e4) == near(30 * U * 100, rel=1e-14)
    stout = spinning((10.0, 60.0, 60.0), (0.0, 3.0, 0.0))
    assert round_off(stout, method(), 1e4) == near(8 * U * 100, rel=1e-14)


def test_a_rounding_of_an_impulse_is_more_of_the_spin_of_a_sphere_of_little_inertia():
    light = Body(mass=2.0, inertia=(0.01, 0.01, 0.01), shape=Sphere(radius=0.5))
    rough = instance([light, POINT], (Contact(law="linear", stiffness=8.0, friction=0.25),))
    # m R^2/J = 2 x 1/4 / 0.01
    assert round_off(rough, method(), 1e4) == near(50 * U * 100, rel=1e-14)
    free = instance([light, POINT])
    assert round_off(free, method(), 1e4) == near(8 * U * 100, rel=1e-14)


@pytest.mark.parametrize(
    ("law", "factor"),
    [
        (Contact(law="linear", stiffness=8.0, friction=0.01), 1.0),
        # mu m R^2/J = 0.25 x 2 x 1/4 / 0.01
        (Contact(law="linear", stiffness=8.0, friction=0.25), 12.5),
        # A tangential spring has no direction of its own, an impact no step.
        (
            Contact(law="linear", stiffness=8.0, friction=0.25, tangential_stiffness=2.0),
            1.0,
        ),
        (Contact(law="rigid", friction=0.25), 1.0),
    ],
)
def test_friction_that_alternates_outgrows_the_errors_of_a_step(law, factor):
    light = Body(mass=2.0, inertia=(0.01, 0.01, 0.01), shape=Sphere(radius=0.5))
    of = instance([light, POINT], (law,))
    assert of_alternating_friction(of) == near(factor, rel=1e-14)
    found = truncation(of, method(), 1 / 64, np.array([0.0, 2.0]))
    np.testing.assert_allclose(found, factor * np.array([1.0, 5.0]) / 32**2, rtol=1e-14)


def test_friction_on_a_point_outgrows_the_errors_of_a_step_by_its_coefficient():
    law = Contact(law="linear", stiffness=8.0, friction=3.0)
    assert of_alternating_friction(instance([POINT, POINT], (law,))) == near(3.0, rel=1e-14)


def test_a_step_that_errs_by_half_of_the_scale_within_tau_resolves_nothing():
    of = instance([POINT, POINT], (Contact(law="linear", stiffness=8.0, friction=8.0),))
    # 8 (h/tau)^2 = 1/2
    subject = Subject(of, method(), (1 / 8, 1 / 16), None)
    assert subject.unresolved(1 / 8) == (
        "friction that alternates may put a step of 0.125 s off by 0.5 of the scale of the motion"
        " within its shortest time"
    )
    assert subject.unresolved(1 / 16) is None
    # Without such friction a long step is judged as ever, and so is a tolerance.
    smooth = instance([POINT, POINT], (Contact(law="linear", stiffness=8.0, friction=0.5),))
    assert Subject(smooth, method(), (4.0,), None).unresolved(4.0) is None
    assert Subject(of, method("tolerance"), (1.0,), None).unresolved(1.0) is None
