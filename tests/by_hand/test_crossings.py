"""How fast event functions cross zero, and how far an error moves an event, with numbers that are
computed on paper.
"""

from math import exp, inf, pi, sqrt

import numpy as np
import pytest

from refdem.checks import _crossings, event_times
from refdem.checks._crossings import Belt, Crossing
from refdem.checks.event_times import CHECK
from refdem.core import discovery
from refdem.core.check import Subject
from refdem.core.quantity import Quantity
from refdem.core.trajectory import Event
from refdem.planning.in_process import truth_of
from refdem.scene import Body, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.force import Force
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.handmade import U, findings, instance, method, near, standing, truth

POINT = Body(mass=2.0)
SPRING = Spring(a=0, b=-1, stiffness=8.0, anchor_b=(0.5, 0.0, 0.0))
BELT = Slider(a=0, friction=0.5, normal_force=6.0, belt_velocity=0.25)
STRIBECK = Slider(
    a=0, law="stribeck", mu0=0.5, mu1=0.125, lambda0=4.0, normal_force=6.0, belt_velocity=0.25
)
DRIVE = Force(a=0, amplitude=3.0, frequency=2.0, phase=0.5)
LIFT = UniformGravity(g=(0.75, 0.0, 0.0))
TIMES = (0.0, 2.0, 4.0, 6.0, 8.0)


def belt(*elements):
    """The forces of a point of 2 kg on a belt."""
    return Belt(instance([POINT], elements).scene)


def test_the_pull_is_that_of_drive_weight_and_spring():
    forces = belt(SPRING, BELT, DRIVE, LIFT)
    assert forces.limit == 3.0
    assert forces.weight == 1.5
    # 3 cos(2 t + 1/2) + 3/2 - 8 (x - 1/2)
    assert forces.pull(0.75, 0.25) == near(3 * np.cos(2.0) + 1.5 + 2.0, rel=1e-14)
    # -6 sin(2 t + 1/2) - 8/4
    assert forces.growth(0.75) == near(-6 * np.sin(2.0) - 2.0, rel=1e-14)
    along_minus_x = Force(a=0, amplitude=3.0, frequency=2.0, phase=0.5, axis=(-1.0, 0.0, 0.0))
    against = belt(SPRING, BELT, along_minus_x)
    assert against.pull(0.75, 0.25) == near(-3 * np.cos(2.0) + 2.0, rel=1e-14)
    assert against.growth(0.75) == near(6 * np.sin(2.0) - 2.0, rel=1e-14)


@pytest.mark.parametrize(("speed", "limit"), [(0.25, 3.0), (-0.25, -3.0)])
def test_a_point_slips_where_the_pull_is_the_limit(speed, limit):
    slider = Slider(a=0, friction=0.5, normal_force=6.0, belt_velocity=speed)
    forces = belt(SPRING, slider, LIFT)
    place = forces.released_at(1.0)
    # P falls while the belt carries the point along: it slips at P = -limit sgn(belt).
    assert forces.pull(1.0, place) == near(-limit, rel=1e-14)
    assert place == near((4.0 + 1.5 + limit) / 8.0, rel=1e-14)


def test_friction_that_falls_with_the_speed_lets_errors_grow():
    assert belt(SPRING, BELT).weakening == 0.0
    # (1/2 - 1/8) 4 x 6 N / 2 kg
    assert belt(SPRING, STRIBECK).weakening == 4.5
    rising = Slider(a=0, law="stribeck", mu0=0.125, mu1=0.5, lambda0=4.0, normal_force=6.0)
    assert belt(SPRING, rising).weakening == 0.0


def of_belt(*elements, **known):
    """A subject on a belt, with truth of x and v at five samples."""
    of = instance([POINT], elements, times=TIMES, quantities={"x": 4.0, "vx": 8.0})
    values = {"x": [0.0, 0.1, 0.2, 0.3, 0.4], "v": [0.0, 1.0, 1.0, 1.0, -1.0]}
    samples = truth(TIMES, values, **known)
    return Subject(of, method(), (1 / 64,), samples), samples


def test_a_slip_crosses_with_the_growth_of_the_pull_and_a_stick_with_the_braking():
    events = {"slip_1": (3.0, 1e-9), "stick_1": (5.0, 2e-9), "slip_2": (7.0, 3e-9)}
    subject, samples = of_belt(SPRING, STRIBECK, scalars=events)
    known = _crossings.rubbing(subject, samples)
    first, second = known["slip"]
    (stick,) = known["stick"]
    assert [c.time for c in (first, stick, second)] == [3.0, 5.0, 7.0]
    assert [c.radius for c in (first, stick, second)] == [1e-9, 2e-9, 3e-9]
    # |P'| = k belt = 2 N/s over k L = 32 N; bends are 1/tau^2, growth 1/tau + weakening.
    assert first.rate == second.rate == 2 / 32
    assert {c.bend for c in (first, stick, second)} == {4.0}
    assert {c.growth for c in (first, stick, second)} == {2.0 + 4.5}
    # It slips again at (4 + 3)/8 m, and was carried there for 2 s: at the stick P = 4 N - 8 x.
    place = 7 / 8 - 0.25 * 2
    pull = 4.0 - 8 * place
    # The slip before, at the sample of t = 4, went along: limit - P decelerate 2 kg; scale 8 m/s.
    assert stick.rate == near((3.0 - pull) / 2 / 8, rel=1e-14)


def test_the_margin_of_a_stick_is_how_far_its_place_may_be_off():
    # P = 4 - 8 x, and friction holds up to 3 N: x between 1/8 and 7/8.
    forces = belt(SPRING, BELT)
    assert forces.margin(5.0, 0.375) == 0.25
    assert forces.margin(5.0, 0.875) == 0.0
    assert forces.margin(5.0, 2.0) == 0.0
    scalars = {"stop_time": (7.57, 1e-9), "stop_position": (0.625, 0.0)}
    subject, samples = of_belt(SPRING, BELT, scalars=scalars)
    (stop,) = _crossings.rubbing(subject, samples)["stop"]
    # In units of L = 4 m.
    assert stop.margin == 0.25 / 4


def test_the_last_stick_is_found_back_from_the_last_sample():
    subject, samples = of_belt(SPRING, BELT, scalars={"stick_1": (5.0, 0.0)})
    (stick,) = _crossings.rubbing(subject, samples)["stick"]
    place = 0.4 - 0.25 * (8 - 5)
    assert stick.rate == near((3.0 - (4.0 - 8 * place)) / 2 / 8 if place > 1 / 8 else 0.0)


@pytest.mark.parametrize(
    ("position", "time", "since", "expected"),
    [
        # P = 4 - 8 x; the limit is 3 N; the mass 2 kg; at t = 2, 4 and 6 the point goes along.
        (0.375, 5.0, 3.0, 1.0),
        (0.625, 5.0, 3.0, 2.0),
        (0.375, 8.5, 7.0, 2.0),
        (0.625, 8.5, 7.0, 1.0),
        (0.375, 3.0, 2.5, 1.0),
        (0.625, 3.0, 2.5, 1.0),
        (1.0, 3.0, 2.5, 0.0),
        (0.375, 4.0, 2.0, 1.0),
    ],
)
def test_the_braking_before_a_stick_knows_the_direction_of_the_slip(
    position, time, since, expected
):
    subject, samples = of_belt(SPRING, BELT)
    found = _crossings.braking(belt(SPRING, BELT), samples, time, position, since)
    assert found == expected
    assert subject.levels == (1 / 64,)


def test_a_stop_is_a_stick_whose_slip_lasted_half_a_period():
    # Half a period is pi sqrt(2/8) = 1.571 s: of a stop at 7.57 s the sample at 6 s shows the slip,
    # of one at 7.58 s none does.
    for time, along in ((7.57, 1), (7.58, None)):
        scalars = {"stop_time": (time, 1e-9), "stop_position": (0.625, 0.0)}
        subject, samples = of_belt(SPRING, BELT, scalars=scalars)
        known = _crossings.rubbing(subject, samples)
        (stop,) = known["stop"]
        assert known["stick"] == [stop]
        pull = 4.0 - 8 * 0.625
        net = 3.0 - (abs(pull) if along is None else along * pull)
        assert (stop.time, stop.radius) == (time, 1e-9)
        assert stop.rate == near(net / 2 / 8, rel=1e-14)
        assert (time - pi / 2 < 6.0) == (along is not None)


BALL = Body(
    mass=2.0,
    inertia=(0.5, 0.5, 0.5),
    velocity=(0, 0, -3.0),
    position=(0, 0, 1.0),
    shape=Sphere(radius=1.0),
)
SOFT = Contact(law="linear", stiffness=8.0)


def pair(relative=(3.0, 4.0, 0.0), gap=0.0, fixed=False, law=SOFT):
    """Two balls along x, of radii 1 and 1/2 m, whose first moves."""
    first = Body(mass=2.0, inertia=(0.5,) * 3, velocity=relative, shape=Sphere(radius=1.0))
    second = Body(
        mass=1.0,
        inertia=(0.5,) * 3,
        position=(1.5 + gap, 0.0, 0.0),
        shape=Sphere(radius=0.5),
        fixed=fixed,
    )
    return instance([first, second], (law,), times=TIMES, quantities={"r1.x": 1.0})


def test_pairs_in_touch_that_close_are_found_with_their_speeds():
    assert _crossings.touches(pair().scene) == [(3.0, 5.0, (0, 1))]
    assert _crossings.touches(pair(fixed=True).scene) == [(3.0, 5.0, (0, 1))]
    assert _crossings.touches(pair(relative=(-3.0, 4.0, 0.0)).scene) == []
    assert _crossings.touches(pair(relative=(0.0, 4.0, 0.0)).scene) == []
    wall = instance([BALL], (SOFT, Plane()))
    assert _crossings.touches(wall.scene) == [(3.0, 3.0, (0,))]
    other_law = instance([BALL], (Contact(law="rigid"), Plane()))
    assert _crossings.touches(other_law.scene) == []
    held = instance([BALL], (SOFT, Plane(), UniformGravity(g=(0, 0, -1.0))))
    assert _crossings.touches(held.scene) == []


def test_a_touch_is_rounded_eight_times_on_the_scale_of_places_and_radii():
    near = pair()
    assert _crossings.rounding(near.scene) == 8 * U * 1.5
    # A place near 1.5 m is a multiple of 2 U.
    for gap, count in ((12 * U, 1), (-10 * U, 1), (14 * U, 0), (-14 * U, 0)):
        assert len(_crossings.touches(pair(gap=gap).scene)) == count


def released(of, scalars, **claims):
    """The crossings of a contact that begins at the start."""
    samples = truth(TIMES, {"r1.x": [0.0] * 5}, scalars=scalars)
    return _crossings.parting(Subject(of, method(**claims), (1 / 64,), samples), samples)


def test_a_contact_begins_at_the_start_and_is_released_with_the_speed_that_is_given_back():
    scalars = {"duration": (0.75, 1e-9), "restitution": (0.5, 0.0)}
    known = released(pair(), scalars)
    (touch,) = known["contact"]
    assert (touch.time, touch.radius, touch.rate, touch.bend) == (0.0, 8 * U * 1.5 / 3, inf, 0.0)
    (release,) = known["release"]
    # One scale of every coordinate of two bodies in a plane changes d by 2 sqrt(2) L.
    reach = 4.0 * 2 * sqrt(2.0)
    assert (release.time, release.radius, release.growth) == (0.75, 1e-9, 2.0)
    assert release.rate == near(3.0 * 0.5 / reach, rel=1e-14)
    assert release.bend == near(5.0 / (reach * 0.5), rel=1e-14)
    assert released(pair(), {})["release"] == []


def test_a_release_at_zero_force_moves_by_the_dashpot_too():
    law = Contact(law="linear", stiffness=8.0, damping=2.0, cutoff="zero_force")
    (release,) = released(pair(law=law), {"duration": (1.0, 0.0), "restitution": (0.5, 0.0)})[
        "release"
    ]
    unit = 4.0 * 2 * sqrt(2.0) * (1 + 2.0 / (8.0 * 0.5))
    assert release.rate == near(1.5 / unit, rel=1e-14)
    assert release.bend == near(10.0 / unit, rel=1e-14)
    ends_with_overlap = Contact(law="linear", stiffness=8.0, damping=2.0)
    (plain,) = released(
        pair(law=ends_with_overlap), {"duration": (1.0, 0.0), "restitution": (0.5, 0.0)}
    )["release"]
    assert plain.rate == near(1.5 / (8 * sqrt(2.0)), rel=1e-14)


def test_what_is_given_back_follows_from_restitution_from_energy_or_from_the_law():
    of = pair()
    for scalars, share in (
        ({"restitution": (0.25, 0.1)}, 0.25),
        # m v^2/2 = 2 x 9/2 = 9 J; 4 of them are lost: sqrt(5/9).
        ({"energy_change": (-4.0, 0.0)}, sqrt(5) / 3),
        ({"energy_change": (-10.0, 0.0)}, 0.0),
        ({}, 1.0),
    ):
        samples = truth(TIMES, {"r1.x": [0.0] * 5}, scalars=scalars)
        subject = Subject(of, method(), (1 / 64,), samples)
        assert _crossings.given_back(subject, samples, 3.0) == near(share, rel=1e-14)
    damped = pair(law=Contact(law="linear", stiffness=8.0, damping=1.0))
    samples = truth(TIMES, {"r1.x": [0.0] * 5})
    assert _crossings.given_back(Subject(damped, method(), (1 / 64,), samples), samples, 3.0) == 0.0


def test_contacts_that_begin_together_are_released_together_only_if_they_close_alike():
    left = Body(
        mass=1.0,
        inertia=(0.1,) * 3,
        position=(-2.0, 0, 0),
        velocity=(1.0, 0, 0),
        shape=Sphere(radius=1.0),
    )
    middle = Body(mass=1.0, inertia=(0.1,) * 3, shape=Sphere(radius=1.0))
    for speed, count in ((-1.0, 1), (-1.0 - 2e-9, 0)):
        right = Body(
            mass=1.0,
            inertia=(0.1,) * 3,
            position=(2.0, 0, 0),
            velocity=(speed, 0, 0),
            shape=Sphere(radius=1.0),
        )
        of = instance([left, middle, right], (SOFT,), times=TIMES, quantities={"r1.x": 1.0})
        known = released(of, {"duration": (1.0, 0.0)})
        assert len(known.get("release", [])) == count


def test_an_overlap_that_is_observed_is_off_by_its_own_scale():
    of = instance([BALL], (SOFT, Plane()), times=TIMES, quantities=[Quantity("overlap", "m", 1.0)])
    (release,) = released(of, {"duration": (1.0, 0.0)})["release"]
    assert release.rate == 3.0 / 4.0
    without = instance([BALL], (SOFT, Plane()), times=TIMES, quantities={"z": 1.0})
    (release,) = released(without, {"duration": (1.0, 0.0)})["release"]
    dimension = next(n for n in (1, 2, 3) if f"dimension:{n}" in without.scene.features)
    assert release.rate == near(3.0 / (4.0 * sqrt(dimension)), rel=1e-14)


RIGID = Contact(law="rigid", restitution=0.5)


def test_the_closing_speed_of_two_balls_is_that_at_the_place_where_straight_lines_meet():
    # The second one, seen from the first: at (3.9, 0.9), going with (-5, 0). They meet at a
    # distance of 1.5 m where y = 0.9 is 3/5 of it: w.n = -5 x 4/5.
    first = Body(mass=1.0, inertia=(0.1,) * 3, velocity=(5.0, 0, 0), shape=Sphere(radius=1.0))
    second = Body(mass=1.0, inertia=(0.1,) * 3, position=(3.9, 0.9, 0.0), shape=Sphere(radius=0.5))
    of = instance([first, second], (RIGID,), times=TIMES, quantities={"r1.x": 1.0})
    closing, bend = _crossings.closing_speed(of.scene)
    assert closing == near(4.0, rel=1e-14)
    # (w^2 - c^2)/R
    assert bend == near(9.0 / 1.5, rel=1e-14)
    samples = truth(TIMES, {"r1.x": [0.0] * 5}, scalars={"impact_time": (0.54, 1e-9)})
    (crossing,) = _crossings.meeting(Subject(of, method(), (1 / 64,), samples), samples)["contact"]
    reach = 4.0 * 2 * sqrt(2.0)
    assert (crossing.time, crossing.radius, crossing.growth) == (0.54, 1e-9, 2.0)
    assert crossing.rate == near(4.0 / reach, rel=1e-14)
    assert crossing.bend == near(6.0 / reach, rel=1e-14)
    falling = instance([BALL], (RIGID, Plane()))
    assert _crossings.closing_speed(falling.scene) == (3.0, 0.0)
    # Two that pass each other do not close.
    wide = Body(mass=1.0, inertia=(0.1,) * 3, position=(3.9, 2.0, 0.0), shape=Sphere(radius=0.5))
    assert _crossings.closing_speed(instance([first, wide], (RIGID,)).scene)[0] == 0.0


@pytest.mark.parametrize(
    ("bodies", "elements", "is_one"),
    [
        ([BALL], (RIGID, Plane()), True),
        ([BALL, BALL], (RIGID,), True),
        ([BALL, BALL], (RIGID, Plane()), False),
        ([BALL], (RIGID,), False),
        ([BALL], (SOFT, Plane()), False),
        ([BALL], (RIGID, Plane(), UniformGravity(g=(0, 0, -1))), False),
        ([BALL, Body(mass=1.0, position=(9.0, 0, 0))], (RIGID,), False),
    ],
)
def test_one_impact_is_that_of_two_free_spheres_or_of_one_and_a_plane(bodies, elements, is_one):
    assert _crossings.is_impact(instance(bodies, elements).scene) == is_one


@pytest.mark.parametrize(
    ("elements", "is_one"),
    [
        ((SPRING, BELT), True),
        ((SPRING, BELT, DRIVE, LIFT), True),
        ((SPRING,), False),
        ((BELT,), False),
        ((SPRING, SPRING, BELT), False),
        ((SPRING, Slider(a=0, axis=(0.0, 1.0, 0.0), friction=0.5, normal_force=1.0)), False),
        ((Spring(a=0, b=-1, stiffness=1.0, length=1.0), BELT), False),
        ((Spring(a=0, b=-1, stiffness=1.0, exponent=1.5), BELT), False),
        ((Spring(a=0, b=-1, stiffness=1.0, quadratic=0.5), BELT), False),
        ((Spring(a=0, b=-1, stiffness=1.0, cubic=0.5), BELT), False),
    ],
)
def test_a_belt_is_one_point_on_a_linear_spring_and_a_slider_along_x(elements, is_one):
    assert _crossings.is_belt(instance([POINT], elements).scene) == is_one


CROSSING = Crossing(time=3.0, radius=1e-9, rate=0.5, bend=0.25, growth=2.0)


def test_an_error_moves_a_zero_by_its_rate_and_a_bend_moves_it_further():
    # rate t - bend t^2/2 = error: t/2 - t^2/8 = 3/8 at t = 1.
    assert event_times.shift(0.375, CROSSING) == near(1.0, rel=1e-14)
    assert event_times.shift(0.0, CROSSING) == 0.0
    # 2 bend error = rate^2 at 1/2: from there on it need not happen.
    assert event_times.shift(0.5, CROSSING) == inf
    assert event_times.shift(0.499999, CROSSING) < 2.0
    assert event_times.shift(0.375, Crossing(3.0, 0.0, 0.5, 0.0, 2.0)) == 0.75


def test_a_zero_between_two_steps_is_located_by_a_chord_or_by_the_order_of_the_method():
    of = instance([POINT], (SPRING,), times=TIMES)

    def located(control="step", **claims):
        return event_times.interpolated(
            Subject(of, method(control, **claims), (0.125,), None), CROSSING
        )

    # |g''| h^2/(8 |g'|) = 1/4 x 1/64 / 4; h/tau = 1/4.
    assert located() == located(order=1) == 1 / 1024
    assert located(order=4) == 1 / 1024 / 16
    assert located("exact") == located("tolerance") == 0.0
    subject = Subject(of, method(), (0.125,), None)
    assert event_times.interpolated(subject, Crossing(3.0, 0.0, 0.0, 0.25, 2.0)) == inf


def test_a_clock_ticks_in_roundings_and_a_method_that_looks_at_ends_of_steps_in_steps():
    of = instance([POINT], (SPRING,), times=TIMES)

    def ticks(level, time=3.0, control="step", **claims):
        return event_times.ticks(Subject(of, method(control, **claims), (level,), None), time)

    assert ticks(0.125, locates_events=True) == 64 * U * 3
    assert ticks(2.0, locates_events=True) == 8 * U * 3
    assert ticks(0.125) == 64 * U * 3 + 0.125
    # A step of its own choice ends at the next sample, 2 s on, at the latest.
    assert ticks(1e-6, control="tolerance") == 8 * U * 3 + 2.0
    assert ticks(1e-6, control="tolerance", locates_events=True) == 8 * U * 3
    assert ticks(0.0, control="exact") == 8 * U * 3
    assert ticks(0.125, time=-3.0, locates_events=True) == 64 * U * 3


def test_an_error_grows_from_the_sample_before_an_event():
    times = np.array(TIMES)
    bound = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
    assert event_times.error_at(CROSSING, bound, times) == near(4.0 * exp(2.0), rel=1e-14)
    at_a_sample = Crossing(4.0, 0.0, 1.0, 0.0, 2.0)
    assert event_times.error_at(at_a_sample, bound, times) == near(4.0 * exp(4.0), rel=1e-14)
    late = Crossing(9.0, 0.0, 1.0, 0.0, 1.0)
    assert event_times.error_at(late, bound, times) == near(16.0 * exp(3.0), rel=1e-14)
    fast = Crossing(3.0, 0.0, 1.0, 0.0, 200.0)
    assert event_times.error_at(fast, bound, times) == near(4.0 * exp(100.0), rel=1e-14)
    first = Crossing(0.0, 0.0, 1.0, 0.0, 2.0)
    assert event_times.error_at(first, bound, times) == 1.0


def slipping(scalars, *, order=2, level=2.0**-12, events=(), x=None, **claims):
    """Findings on the events of a run on a belt whose x is that of truth, but for what is given."""
    of = instance([POINT], (SPRING, BELT), times=TIMES, quantities={"x": 4.0})
    values = {"x": [0.0, 0.1, 0.2, 0.3, 0.4], "v": [0.0, 1.0, 1.0, 1.0, -1.0]}
    samples = truth(TIMES, values, scalars=scalars)
    subject = Subject(of, method(order=order, **claims), (level,), samples)
    seen = values["x"] if x is None else x
    run = standing(of, position=[[[place, 0.0, 0.0]] for place in seen], events=tuple(events))
    return subject, findings(CHECK, subject, run)


def test_the_bound_on_a_slip_is_the_observed_error_over_its_rate_and_a_step():
    h = 2.0**-12
    # x is off by 4 m times 2^-20 at all samples.
    x = [value + 2.0**-18 for value in (0.0, 0.1, 0.2, 0.3, 0.4)]
    event = Event(3.0 + 2 * h, "slip", 0)
    for claims, step in (({}, h), ({"locates_events": True}, 0.0)):
        room = 16.0 if claims else 64.0
        subject, found = slipping({"slip_1": (3.0, 1e-9)}, events=[event], x=x, **claims)
        noise = subject.noise(h)
        error = (room * 2.0**-20 + 20 * noise) * exp(2.0 * 1.0)
        claimed = (9 * (2 * h) ** 2 + noise) * exp(2.0 * 1.0)
        slip = Crossing(3.0, 1e-9, 2 / 32, 4.0, 2.0)
        chord = 4.0 * h**2 / (8 * (2 / 32))
        shift = min(event_times.shift(error, slip) + chord, event_times.shift(claimed, slip))
        allowed = shift + 1e-9 + 8 / h * U * 3 + step
        assert found["slip"].value == near(2 * h / 0.5, rel=1e-9)
        assert found["slip"].bound == near(allowed / 0.5, rel=1e-9)
        assert found["slip"].sharpness == near(allowed / 3.0, rel=1e-6)


def test_events_are_predicted_in_their_order_whatever_their_kind():
    """A stick beyond the horizon says nothing about the slip before it."""
    scalars = {"slip_1": (3.0, 0.0), "stick_1": (7.0, 0.0)}
    of = instance([POINT], (SPRING, BELT), times=TIMES, quantities={"x": 4.0})
    values = {"x": [0.0, 0.1, 0.2, 0.3, 0.4], "v": [0.0, 1.0, 1.0, 1.0, -1.0]}
    samples = truth(TIMES, values, scalars=scalars, growth=[1.0, 1.0, 1.0, 1.0, 1e9])
    subject = Subject(of, method(), (2.0**-12,), samples)
    run = standing(of, position=[[[x, 0, 0]] for x in values["x"]], events=(Event(3.0, "slip", 0),))
    found = findings(CHECK, subject, run)
    assert {kind: finding.outcome for kind, finding in found.items()} == {"slip": "pass"}


def test_a_clock_may_begin_at_any_time():
    """The signal beside a time is how long ago the run began, and not what its clock shows."""
    times = tuple(t + 2.0 for t in TIMES)
    of = instance([POINT], (SPRING, BELT), times=times, quantities={"x": 4.0})
    values = {"x": [0.0, 0.1, 0.2, 0.3, 0.4], "v": [0.0, 1.0, 1.0, 1.0, -1.0]}
    samples = truth(times, values, scalars={"slip_1": (5.0, 0.0)})
    subject = Subject(of, method(), (2.0**-12,), samples)
    place = [[[x, 0.0, 0.0]] for x in values["x"]]
    run = standing(of, position=place, events=(Event(5.0, "slip", 0),))
    slip = findings(CHECK, subject, run)["slip"]
    assert slip.sharpness == near(slip.bound * 0.5 / (5.0 - 2.0), rel=1e-12)
    # An event that never was is off by its distance from the nearest one.
    early = standing(of, position=place, events=(Event(2.5, "slip", 0), Event(5.0, "slip", 0)))
    assert findings(CHECK, subject, early)["slip"].value == near(2.5 / 0.5, rel=1e-12)


def test_a_bound_that_claims_alone_give_is_used_where_it_is_smaller():
    h = 2.0**-12
    x = [value + 0.1 for value in (0.0, 0.1, 0.2, 0.3, 0.4)]
    subject, found = slipping({"slip_1": (3.0, 0.0)}, events=[Event(3.0, "slip", 0)], x=x)
    claimed = (9 * (2 * h) ** 2 + subject.noise(h)) * exp(2.0)
    slip = Crossing(3.0, 0.0, 2 / 32, 4.0, 2.0)
    allowed = event_times.shift(claimed, slip) + 8 / h * U * 3 + h
    assert found["slip"].bound == near(allowed / 0.5, rel=1e-9)


def test_an_event_whose_time_may_be_off_by_a_tenth_of_tau_ends_what_is_predicted():
    _, found = slipping({"slip_1": (3.0, 0.0)}, events=[Event(3.0, "slip", 0)], level=0.125)
    assert found["slip"].outcome == "undecided"
    assert "use smaller steps. At t = 3 s an error" in found["slip"].sentence
    assert "shifts the time of an event by more than tau/10" in found["slip"].sentence


ONE = Crossing(1.0, 0.0, 1.0, 0.0, 1.0, bodies=(0, 1))
TWO = Crossing(2.0, 0.0, 1.0, 0.0, 1.0, bodies=(1, 2))
KNOWN = [(ONE, 0.25), (TWO, 0.5)]


def told(*events):
    """What events of bodies at times are told of two impacts that are due."""
    listed = [Event(time, "contact", body) for time, body in events]
    return event_times.one_to_one(listed, KNOWN, KNOWN, 9.0)


def test_every_impact_takes_one_event_of_its_bodies_and_what_is_left_never_was():
    assert told((1.125, 0), (2.25, 2)) == [(0.125, 0.25, 1.0), (0.25, 0.5, 2.0)]
    # Told for each of its bodies: within the bound it is the same event, beyond it another.
    assert told((1.0, 0), (1.25, 1), (2.0, 2)) == [(0.0, 0.25, 1.0), (0.0, 0.5, 2.0)]
    assert told((1.0, 0), (1.375, 1), (2.0, 2)) == [
        (0.0, 0.25, 1.0),
        (0.0, 0.5, 2.0),
        (9.0, 0.0, 1.375),
    ]
    # Twice of the same body is one too many, and none is one too few.
    assert told((1.0, 0), (1.0, 0), (2.0, 2)) == [
        (0.0, 0.25, 1.0),
        (0.0, 0.5, 2.0),
        (9.0, 0.0, 1.0),
    ]
    assert told((1.0, 0)) == [(0.0, 0.25, 1.0), (9.0, 0.5, 2.0)]
    assert told((1.0, 3), (2.0, 2)) == [(9.0, 0.25, 1.0), (0.0, 0.5, 2.0), (9.0, 0.0, 1.0)]


def test_an_impact_that_is_not_due_takes_an_event_within_its_bound_alone():
    listed = [Event(1.25, "contact", 0), Event(2.625, "contact", 2)]
    assert event_times.one_to_one(listed, KNOWN, [], 9.0) == [
        (0.25, 0.25, 1.0),
        (9.0, 0.0, 2.625),
    ]
    # One that is told before it is due is compared, and one that is not told is not missed.
    early = [Event(1.25, "contact", 0)]
    assert event_times.one_to_one(early, KNOWN, [], 9.0) == [(0.25, 0.25, 1.0)]


def test_the_share_of_a_bound_of_zero_is_infinite():
    assert event_times._share_of_bound((0.5, 0.25, 1.0)) == 2.0
    assert event_times._share_of_bound((0.0, 0.0, 1.0)) == inf


def test_a_time_is_compared_with_the_nearest_certified_one():
    def nearest(time, body, known=KNOWN):
        return event_times.nearest(Event(time, "contact", body), known, 9.0)

    assert nearest(1.75, 1) == (0.25, 0.5, 1.75)
    assert nearest(1.25, 1) == (0.25, 0.25, 1.25)
    assert nearest(1.25, 1, []) == (9.0, 0.0, 1.25)
    # One of another body is none of these.
    assert nearest(1.25, 2) == (0.75, 0.5, 1.25)
    assert nearest(1.25, 3) == (9.0, 0.0, 1.25)
    anyones = Crossing(1.0, 0.0, 1.0, 0.0, 1.0)
    assert nearest(1.25, 3, [(anyones, 0.25)]) == (0.25, 0.25, 1.25)


def test_a_certified_time_is_compared_with_the_nearest_that_is_told_of_its_bodies():
    events = [Event(1.25, "contact", 2), Event(1.5, "contact", 0), Event(3.0, "contact", 1)]
    assert event_times.reported(ONE, 0.25, events, 9.0) == (0.5, 0.25, 1.0)
    assert event_times.reported(ONE, 0.25, events[:1], 9.0) == (9.0, 0.25, 1.0)
    assert event_times.reported(ONE, 0.25, [], 9.0) == (9.0, 0.25, 1.0)


def test_a_contact_is_told_of_the_bodies_that_meet_and_of_no_bystander():
    bystander = Body(
        mass=1.0, inertia=(0.5,) * 3, position=(0.0, 9.0, 0.0), shape=Sphere(radius=0.5)
    )
    first = Body(mass=2.0, inertia=(0.5,) * 3, velocity=(3.0, 0.0, 0.0), shape=Sphere(radius=1.0))
    second = Body(mass=1.0, inertia=(0.5,) * 3, position=(1.5, 0.0, 0.0), shape=Sphere(radius=0.5))
    of = instance([bystander, first, second], (SOFT,), times=TIMES, quantities={"r1.x": 1.0})
    known = released(of, {"duration": (0.75, 1e-9), "restitution": (0.5, 0.0)})
    assert {crossing.bodies for kind in known.values() for crossing in kind} == {(1, 2)}


@pytest.mark.parametrize(("precision", "unit"), [("double", 2.0**-53), ("single", 2.0**-24)])
def test_a_touch_at_the_start_is_known_to_a_rounding_of_the_method(precision, unit):
    asked = discovery.case("two-spheres").at()
    samples = truth_of(asked)
    subject = Subject(asked, method(precision=precision), (1 / 64,), samples)
    (touch,) = _crossings.parting(subject, samples)["contact"]
    bodies = asked.scene.bodies
    reach = max(bodies.radius.max(), np.abs(bodies.position).max())
    closing = bodies.velocity[0, 0] - bodies.velocity[1, 0]
    assert touch.radius == near(8 * unit * reach / closing, rel=1e-14)
