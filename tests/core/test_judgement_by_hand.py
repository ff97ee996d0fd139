"""Errors, signals and what runs predict for each other, with numbers that are computed on paper: a
factor that is off by a half is seen here.
"""

from math import cos, inf, nan, pi, sin

import msgspec
import numpy as np
import pytest

from refdem.core.check import Subject
from refdem.core.judgement import (
    Sight,
    certified,
    curve,
    difference,
    distances,
    errors,
    followed,
    growth_shown,
    judged,
    largest_so_far,
    left_at_finest,
    movements,
    order_statement,
    perturbation,
    predictable,
    room_of,
    sharpest,
    signed,
    worst,
)
from refdem.core.quantity import Quantity
from refdem.errors import EngineError
from refdem.scene import Body, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from tests.handmade import HandMade, instance, method, standing, truth

TIMES = (0.0, 1.0, 2.0)
POINT = Body(mass=1.0, position=(1.0, 0.0, 0.0))
BALL = Body(mass=1.0, inertia=(0.1, 0.1, 0.1), shape=Sphere(radius=0.5))
TOUCHING = (Contact(law="linear", stiffness=1.0), Plane())
WORDS = {"check": "c", "quantity": "q", "unit": "1", "basis": "b", "what": "w"}


def places(*x):
    """Positions (T, 1, 3) on the x axis."""
    return [[[value, 0.0, 0.0]] for value in x]


def test_errors_are_small_up_to_a_quarter_of_the_scale_and_a_quarter_is_small():
    assert predictable({"x": np.array([0.0, 0.25, 0.2500001, 0.1])}) == 2
    assert predictable({"x": np.array([0.0, 0.25]), "y": np.array([0.1, 0.2])}) == 2
    assert predictable({"x": np.array([0.0, 0.1, 0.1]), "y": np.array([0.1, 0.3, 0.1])}) == 1
    assert predictable({"x": np.array([0.1, nan, 0.1])}) == 1


def test_a_bound_is_blind_above_a_tenth_of_the_signal_and_not_at_it():
    assert not Sight(0.125, 1.25).is_blind
    assert Sight(0.1250001, 1.25).is_blind
    assert not Sight(5.0, 0.0).is_blind
    assert Sight(0.5, 4.0).sharpness == 0.125
    assert Sight(0.5, 0.0).sharpness is None


def test_the_sharpest_sample_has_the_least_bound_over_the_largest_signal_so_far():
    bounds = np.array([1.0, 3.0, 4.0, 9.0])
    assert sharpest(bounds, np.array([0.0, 6.0, 5.0, 10.0])) == Sight(3.0, 6.0)
    assert sharpest(bounds, np.zeros(4)) == Sight(1.0, 0.0)
    # Nothing has moved where nothing may: that sample sees nothing.
    assert sharpest(np.array([0.0, 1.0]), np.array([0.0, 2.0])) == Sight(1.0, 2.0)


@pytest.mark.parametrize(("value", "outcome"), [(0.5, "pass"), (0.5000001, "fail"), (nan, "fail")])
def test_a_value_at_its_bound_is_within_it(value, outcome):
    finding = judged(value=value, bound=0.5, **WORDS)
    assert finding.outcome == outcome
    assert finding.bound == 0.5
    words = {0.5: "within the bound 0.5", 0.5000001: "above the bound 0.5"}
    assert words.get(value, "not a number (the bound is 0.5)") in finding.sentence


def test_the_worst_sample_is_that_of_the_largest_share_of_its_bound():
    t = np.arange(4.0)
    found = worst(
        t=t, values=np.array([1.0, 2.0, 3.0, 0.0]), allowed=np.array([4.0, 3.0, 5.0, 0.0]), **WORDS
    )
    assert (found.value, found.bound, found.outcome) == (2.0, 3.0, "pass")
    broken = worst(t=t, values=np.array([1.0, nan, 9.0, 0.0]), allowed=1.0, **WORDS)
    assert (np.isnan(broken.value), broken.outcome) == (True, "fail")
    beyond_nothing = worst(
        t=t, values=np.array([0.9, 1e-9, 0, 0]), allowed=np.array([1, 0, 0, 0]), **WORDS
    )
    assert (beyond_nothing.value, beyond_nothing.bound) == (1e-9, 0.0)
    seen = worst(t=t, values=np.zeros(4), allowed=1.0, signal=np.array([1, 2, 30, 4.0]), **WORDS)
    assert seen.sharpness == 1 / 30


def test_a_curve_keeps_256_points_and_the_largest_value_of_each_stretch():
    short = curve(np.arange(256.0), np.zeros(256), 1.0)
    assert len(short.t) == 256
    value = np.zeros(512)
    value[[1, 2, 300]] = (5.0, 7.0, 9.0)
    kept = curve(np.arange(512.0), value, np.arange(512.0))
    assert len(kept.t) == 256
    assert kept.t[:2] == [1.0, 2.0]
    assert kept.value[:3] == [5.0, 7.0, 0.0]
    assert kept.value[150] == 9.0
    assert kept.bound[150] == 300.0


@pytest.mark.parametrize(
    ("deficit", "seen", "words"),
    [
        (0.25, 1.75, "meets the claimed 2 (tolerance 0.25)"),
        (0.2500001, 1.75, "is below the claimed 2 by 0.25 (tolerance 0.25)"),
        (0.1, 1.7, "approaches the claimed 2 (extrapolated deficit 0.1, tolerance 0.25)"),
        (nan, 1.0, "is below the claimed 2 by nan"),
    ],
)
def test_an_order_meets_approaches_or_misses_the_claimed_one(deficit, seen, words):
    assert words in order_statement(seen, 2.0, deficit, 0.25, "by hand")


def test_an_error_is_the_distance_less_the_radius_over_the_scale():
    of = instance([POINT], times=TIMES, quantities={"x": 2.0, "vy": 4.0})
    known = truth(TIMES, {"x": [1.0, 1.0, 1.0], "vy": [0.0, 0.0, 0.0]}, radius=0.25)
    run = standing(
        of, position=places(1.0, 0.5, 1.125), velocity=[[[0.0, y, 0.0]] for y in (0, 1, -5)]
    )
    found = errors(of, run, known)
    np.testing.assert_array_equal(found["x"], [0.0, 0.125, 0.0])
    np.testing.assert_array_equal(found["vy"], [0.0, 0.1875, 1.1875])
    np.testing.assert_array_equal(
        signed(Subject(of, method(), (1.0,), known), run, known, 2), [[0.0, -0.25], [0.0, 0.25]]
    )


def test_what_is_not_certified_is_not_compared():
    of = instance([POINT], times=TIMES, quantities={"x": 2.0, "y": 1.0})
    known = truth(TIMES, {"x": [1.0, 1.0, 1.0]}, until=2)
    run = standing(of, position=places(1.0, 0.5, 7.0))
    found = errors(of, run, known)
    assert list(found) == ["x"]
    np.testing.assert_array_equal(found["x"], [0.0, 0.25])
    with pytest.raises(EngineError, match="expected x, y"):
        errors(of, run, truth(TIMES, {"z": [0.0] * 3}))


def test_angles_are_compared_modulo_a_turn_and_keep_their_sign():
    of = instance([POINT], times=TIMES, quantities=[Quantity("theta", "rad", 0.5, angle=True)])
    near_pi = [[[cos(a), sin(a), 0.0]] for a in (3.0, -3.0, pi)]
    run = standing(of, position=near_pi)
    known = truth(TIMES, {"theta": [3.0, 3.25, 0.0]})
    subject = Subject(of, method(), (1.0,), known)
    (found,) = signed(subject, run, known, 3)
    np.testing.assert_allclose(found[:2], [0.0, 2 * (2 * pi - 6.25)], atol=1e-14)
    # Half a turn is one either way.
    assert abs(found[2]) == pytest.approx(2 * pi, rel=1e-14)
    np.testing.assert_allclose(errors(of, run, known)["theta"], np.abs(found), atol=1e-14)
    moved = movements(of, truth(TIMES, {"theta": [3.0, -3.0, 2.5]}))["theta"]
    np.testing.assert_allclose(moved, [0.0, 2 * (2 * pi - 6.0), 1.0], rtol=1e-14)


def test_angles_of_many_turns_are_compared_to_the_rounding_of_a_turn():
    """theta = -1040 differs from its remainder by 0 to a rounding of 1 rad, not of 1040 rad."""
    turned = np.array([-1040.0, 1e6, 40.4])
    apart = difference(np.arctan2(np.sin(turned), np.cos(turned)), turned, is_angle=True)
    assert np.max(np.abs(apart)) < 1e-15
    off = difference(turned + 2**-20, turned, is_angle=True)
    np.testing.assert_allclose(off, 2**-20, atol=1e-15)


def test_a_movement_is_counted_from_the_start_in_units_of_the_scale():
    of = instance([POINT], times=TIMES, quantities={"x": 4.0})
    np.testing.assert_array_equal(
        movements(of, truth(TIMES, {"x": [1.0, 3.0, -2.0]}))["x"], [0.0, 0.5, 0.75]
    )


class Turning(HandMade):
    """A case that compares an attitude."""

    def observe(self, p, trajectory):
        return {f"attitude.{axis}": trajectory.attitude[:, 0, k] for k, axis in enumerate("wxyz")}


def turning(times=TIMES):
    """An instance whose one quantity is an attitude."""
    of = instance([BALL], times=times)
    group = [Quantity(f"attitude.{axis}", "1", 1.0, group="attitude") for axis in "wxyz"]
    case = Turning(of.scene, times, of.scales, group)
    return type(of)(case, of.p)


def test_an_attitude_is_off_by_the_angle_of_one_rotation_less_twice_the_radius():
    of = turning()
    half = np.array([0.0, 0.1, -0.25])
    attitude = np.stack([np.cos(half), np.zeros(3), np.zeros(3), np.sin(half)], axis=1)
    # Neither the length nor the sign of a quaternion says anything about its attitude.
    run = standing(of, attitude=(-3.0 * attitude)[:, None])
    names = [f"attitude.{axis}" for axis in "wxyz"]
    upright = dict(zip(names, ([1.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3), strict=True))
    exact = errors(of, run, truth(TIMES, upright))["attitude"]
    np.testing.assert_allclose(exact, [0.0, 0.2, 0.5], atol=1e-15)
    with_radius = errors(of, run, truth(TIMES, upright, radius=0.05))["attitude"]
    np.testing.assert_allclose(with_radius, [0.0, 0.1, 0.4], atol=1e-15)
    known = truth(TIMES, upright)
    subject = Subject(of, method(), (1.0,), known)
    found = signed(subject, run, known, 3)
    sines = 2 * np.sin(half)
    np.testing.assert_allclose(found, [[0.0] * 3, [0.0] * 3, sines], atol=1e-15)
    same = signed(subject, standing(of, attitude=attitude[:, None]), known, 3)
    np.testing.assert_allclose(same, found, atol=1e-15)


class Physical(Turning):
    """A case that looks at no attitude but a unit quaternion, and at an angle and a speed."""

    def observe(self, p, trajectory):
        np.testing.assert_allclose(np.linalg.norm(trajectory.attitude, axis=-1), 1.0, rtol=1e-15)
        return super().observe(p, trajectory) | {"vx": trajectory.velocity[:, 0, 0]}


def test_a_case_is_shown_unit_quaternions_where_it_is_asked_what_it_depends_on():
    of = turning()
    group = [Quantity(f"attitude.{axis}", "1", 1.0, group="attitude") for axis in "wxyz"]
    case = Physical(of.scene, TIMES, of.scales, [*group, Quantity("vx", "m/s", 2.0)])
    of = type(of)(case, of.p)
    names = [f"attitude.{axis}" for axis in "wxyz"]
    upright = dict(zip(names, ([1.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3), strict=True))
    known = truth(TIMES, upright | {"vx": [0.0] * 3})
    late = {"vx": [0.5] * 3}
    delayed = msgspec.structs.replace(known, earlier={0.25: (late, {"vx": [0.0] * 3})})
    found = errors(of, standing(of), delayed, 0.25)
    # The attitude is compared with its own time, the speed with that of a quarter of a second ago.
    assert {name: value.tolist() for name, value in found.items()} == {
        "attitude": [0.0] * 3,
        "vx": [0.25] * 3,
    }


def test_the_largest_error_so_far_is_that_of_any_quantity():
    of = instance([POINT], times=TIMES, quantities={"x": 2.0, "vy": 4.0})
    known = truth(TIMES, {"x": [1.0] * 3, "vy": [0.0] * 3})
    run = standing(
        of, position=places(1.0, 1.2, 1.0), velocity=[[[0, 0, 0]], [[0, 0.2, 0]], [[0, 0.2, 0]]]
    )
    subject = Subject(of, method(), (1.0,), known)
    np.testing.assert_allclose(largest_so_far(subject, 1.0, run, known), [0.0, 0.1, 0.1])
    assert followed(subject, 1.0, run, known, 0.05) == 1
    assert followed(subject, 1.0, run, known, 0.11) == 3


def test_a_run_follows_the_truth_up_to_a_tenth_of_the_scale():
    of = instance([POINT], times=TIMES, quantities={"x": 1.0})
    known = truth(TIMES, {"x": [0.0] * 3})
    subject = Subject(of, method(), (1.0,), known)
    at_it = standing(of, position=places(0.0, 0.1, 0.1))
    assert followed(subject, 1.0, at_it, known) == 3
    beyond = standing(of, position=places(0.0, 0.1, 0.101))
    assert followed(subject, 1.0, beyond, known) == 2


def test_truth_counts_from_two_certified_samples_on():
    of = instance([POINT], times=TIMES, quantities={"x": 1.0})
    for until, counts in ((1, False), (2, True)):
        known = truth(TIMES, {"x": [0.0] * 3}, until=until)
        assert (certified(Subject(of, method(), (1.0,), known)) is known) == counts


def test_the_room_beside_a_prediction_is_4_and_64_or_16_where_kinks_scatter_errors():
    smooth = instance([POINT])
    touching = instance([BALL], TOUCHING)
    assert room_of(Subject(smooth, method(), (1.0,), None)) == 4
    assert room_of(Subject(touching, method(), (1.0,), None)) == 64
    assert room_of(Subject(touching, method(locates_events=True), (1.0,), None)) == 16


def test_errors_fall_from_the_coarsest_to_the_finest_step_with_the_order():
    coarse = np.array([0.5, 2.0, 1.0])
    smooth = instance([POINT])
    assert left_at_finest(Subject(smooth, method(), (0.5, 0.25, 0.125), None), coarse) == 0.5
    assert left_at_finest(Subject(smooth, method(order=3), (0.5, 0.25), None), coarse) == 1.0
    touching = instance([BALL], TOUCHING)
    assert left_at_finest(Subject(touching, method(), (0.5, 0.25), None), coarse) == inf
    by_tolerance = Subject(smooth, method("tolerance"), (1e-4, 1e-6), None)
    assert left_at_finest(by_tolerance, coarse) == inf
    stepped = Subject(smooth, method(), (0.5, 0.25), None)
    assert left_at_finest(stepped, np.array([0.0, nan])) == inf


@pytest.mark.parametrize(
    ("sizes", "bound"),
    [
        # Pairs show the order 2: the coarsest level predicts, 4 x 1.6e-3/16 is 4 x 0.4e-3/4.
        ((1.6e-3, 0.4e-3, 0.1e-3), 4e-4),
        # Orders 0.2 and 1.6, as terms cancel at the coarsest level: the middle one predicts.
        ((1e-3, 2**-0.2 * 1e-3, 2**-1.8 * 1e-3), 2**-0.2 * 1e-3),
        # Deficits of 1.8 and 0.85.
        ((1e-3, 2**-0.2 * 1e-3, 2**-1.35 * 1e-3), 2**-0.2 * 1e-3),
        # Deficits of 1.8 and 0.89, 1.4 and 0.8, 1.4 and 0.71, and 1 and 1: the coarsest predicts.
        ((1e-3, 2**-0.2 * 1e-3, 2**-1.31 * 1e-3), 2.5e-4),
        ((1e-3, 2**-0.6 * 1e-3, 2**-1.8 * 1e-3), 2.5e-4),
        ((1e-3, 2**-0.6 * 1e-3, 2**-1.89 * 1e-3), 2.5e-4),
        ((1e-3, 0.5e-3, 0.25e-3), 2.5e-4),
        # Errors that rise, or stay, show no order; none at all has none.
        ((1e-3, 2e-3, 4e-3), 2.5e-4),
        ((1e-3, 2e-3, 0.0), 2.5e-4),
        # The last pair alone shows nothing.
        ((1e-3, 1e-3), 2.5e-4),
    ],
)
def test_where_terms_cancel_at_the_coarsest_level_a_later_one_predicts(sizes, bound):
    of = Subject(instance([POINT]), method(), (0.5, 0.25, 0.125), None)
    changes = [np.array([0.0, size]) for size in sizes]
    assert left_at_finest(of, *changes) == pytest.approx(bound, rel=1e-12)


def test_two_runs_are_as_far_apart_as_their_largest_difference_in_any_scale():
    # L = 4 m, L/tau = 8 m/s; the largest omega at the start is 2 rad/s.
    spinning = Body(mass=1.0, inertia=(0.1, 0.1, 0.1), omega=(0.0, 0.0, 2.0))
    of = instance([spinning, POINT], times=TIMES)
    base = standing(of)

    def off_by(column, value):
        values = np.array(getattr(base, column))
        values[1, 0, 1] += value
        return distances(of, standing(of, **{column: values}), base)

    np.testing.assert_array_equal(off_by("position", 1.0), [0.0, 0.25, 0.0])
    np.testing.assert_array_equal(off_by("velocity", -1.0), [0.0, 0.125, 0.0])
    np.testing.assert_array_equal(off_by("omega", 0.5), [0.0, 0.25, 0.0])
    turned = np.array(base.attitude)
    turned[2, 0] = [cos(0.3), 0.0, sin(0.3), 0.0]
    np.testing.assert_allclose(
        distances(of, standing(of, attitude=turned), base), [0.0, 0.0, 0.6], atol=1e-15
    )
    # A point has no attitude that means anything.
    point = np.array(base.attitude)
    point[2, 1] = [0.0, 1.0, 0.0, 0.0]
    assert not distances(of, standing(of, attitude=point), base).any()


def test_spins_of_bodies_that_touch_are_compared_with_what_an_impulse_gives():
    """An impulse m V at the lever R gives m V R/J, of which a rounding is a spin.

    m V R/J = 8 x 0.5/0.1 = 40 rad/s, more than 1/tau = 2 rad/s.
    """
    ball = Body(mass=1.0, inertia=(0.1, 0.1, 0.1), shape=Sphere(radius=0.5))
    rubbing = Contact(law="linear", stiffness=1.0, friction=0.5)
    of = instance([ball], (rubbing, Plane()), times=TIMES)
    assert "rotation" in of.scene.features
    base = standing(of)
    omega = np.array(base.omega)
    omega[1, 0, 2] = 0.5
    np.testing.assert_array_equal(distances(of, standing(of, omega=omega), base), [0, 0.0125, 0])


def test_fast_spins_are_compared_with_the_fastest_of_the_run_and_angles_with_its_turn_in_tau():
    """After an impact a small sphere spins much faster than at the start."""
    # tau = 1/2 s.
    slow = Body(mass=1.0, inertia=(0.1, 0.1, 0.1), omega=(0.0, 0.0, 2.0))
    of = instance([slow], times=TIMES)
    base = standing(of)
    spun = np.array(base.omega)
    spun[2, 0, 0] = 200.0
    fast = standing(of, omega=spun)
    other = np.array(spun)
    other[2, 0, 1] = 0.5
    fastest = np.sqrt(200.0**2 + 2.0**2)
    np.testing.assert_allclose(
        distances(of, standing(of, omega=other), fast), [0, 0, 0.5 / fastest], rtol=1e-15
    )
    turned = np.array(base.attitude)
    turned[1, 0] = [cos(0.3), 0.0, sin(0.3), 0.0]
    # omega tau = 100 rad.
    np.testing.assert_allclose(
        distances(of, standing(of, omega=spun, attitude=turned), fast),
        [0, 0.6 / (fastest / 2), 0],
        rtol=1e-12,
    )


def test_a_start_is_perturbed_by_64_roundings_of_the_precision_and_errors_may_grow_eightfold_more():
    assert perturbation(method()) == 64
    assert perturbation(method(precision="single")) == 64 * 2**29
    of = instance([POINT], times=TIMES)
    base = standing(of)
    # Neighbours 2^-44 of L = 4 m apart: 4 times the perturbation of 2^-46, then less.
    moved = standing(of, position=places(1.0, 1.0 + 2.0**-42, 1.0 + 2.0**-43))
    np.testing.assert_array_equal(growth_shown(of, method(), moved, base), [1.0, 32.0, 32.0])
    near = standing(of, position=places(1.0, 1.0 + 2.0**-52, 1.0))
    np.testing.assert_array_equal(growth_shown(of, method(), near, base), [1.0, 1.0, 1.0])
