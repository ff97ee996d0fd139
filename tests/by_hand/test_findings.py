"""Value and bound of findings as numbers that are computed on paper: a check whose bound is wider
by a half misses faults, and no outcome of a right or a wrong run tells.

SCALES: L = 4 m, tau = 1/2 s, L/tau = 8 m/s, T = 8 s, m (L/tau)^2 = 128 J.
"""

from math import cos, cosh, exp, hypot, inf, pi, sin, sinh, sqrt

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.trajectory import Cost
from refdem.core.variant import Variant
from refdem.scene import Body, Sphere
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.catch import Catch
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.handmade import U, findings, instance, method, near, standing, truth

TIMES = (0.0, 2.0, 4.0, 6.0, 8.0)
LEVELS = (2.0**-3, 2.0**-4, 2.0**-5)
ROUND_OFF = 8 * U * 16
"""At any of these levels: T/tau = 16 is at least the root of the steps."""
POINT = Body(mass=2.0, position=(3.0, 0.0, 0.0), velocity=(0.0, 4.0, 0.0))
BALL = Body(mass=2.0, inertia=(0.8,) * 3, shape=Sphere(radius=1.0))
SMALL = Body(mass=1.0, inertia=(0.1,) * 3, position=(3.0, 0, 0), shape=Sphere(radius=0.5))
SPRING = Spring(a=0, b=-1, stiffness=3.0)
SOFT = Contact(law="linear", stiffness=8.0)


def judged(name, of, run, claims=None, levels=LEVELS, known=None):
    """Findings of a check on one run for all variants, or on `run(variant)`."""
    subject = Subject(of, claims or method(), levels, known)
    return findings(discovery.check(name), subject, run)


def truncated(level, order=2, constant=1.0, times=TIMES):
    """C (1 + t/tau) (h/tau)^p at the samples."""
    return constant * (1 + 2 * np.array(times)) * (2 * level) ** order


def shifted(of, column, row, body, vector):
    """The run that stands still, with a column changed at one sample."""
    values = np.array(getattr(standing(of), column))
    values[row, body] += vector
    return standing(of, **{column: values})


# Rods


def on_a_rod(**columns):
    """A point on a rod of 3 m; what it drifts by is told by columns."""
    of = instance([POINT], (Rod(a=0, b=-1, length=3.0),))
    return of, standing(of, **columns)


def test_a_rod_is_held_to_its_length_and_its_ends_to_no_speed_along_it():
    place = [[[3.0, 0, 0]], [[0, 3.0, 4.0]], [[3.0, 0, 0]], [[3.0, 0, 0]], [[3.0, 0, 0]]]
    speed = [[[0, 4.0, 0]], [[9.0, 2.0, 1.0]], [[0, 4.0, 0]], [[0, 4.0, 0]], [[0, 4.0, 0]]]
    of, run = on_a_rod(position=place, velocity=speed)
    claims = method(conserves=frozenset({"constraint"}), derived={})
    found = judged("constraint", of, run, claims)
    # |5 - 3|/4, and (3 x 2 + 4 x 1)/5 = 2 m/s over 8.
    assert (found["length"].value, found["velocity"].value) == (0.5, 0.25)
    assert found["length"].bound == found["velocity"].bound == near(ROUND_OFF)


def test_rods_far_away_are_rounded_on_the_scale_of_their_ends():
    far = Body(mass=1.0, position=(40.0, 0, 0))
    nearer = Body(mass=1.0, position=(37.0, 0, 0))
    of = instance([far, nearer], (Rod(a=0, b=1, length=3.0),))
    claims = method(conserves=frozenset({"constraint"}))
    run = shifted(of, "velocity", 2, 1, (-4.0, 0, 0))
    found = judged("constraint", of, run, claims)
    assert found["velocity"].value == 0.5
    assert found["length"].bound == near(ROUND_OFF * 10, rel=1e-13)


def test_a_rod_that_is_kept_to_the_order_has_the_smaller_of_two_bounds():
    of, still = on_a_rod()
    coarse = shifted(of, "position", 2, 0, (0.001, 0, 0))
    fine = shifted(of, "position", 2, 0, (0.0001, 0, 0))
    found = judged("constraint", of, lambda variant: coarse if variant.level == LEVELS[0] else fine)
    # 4 x (0.001/4) / 2^(2 x 2) + 20 roundings, against 9 (1/16)^2.
    assert found["length"].value == near(0.0001 / 4, rel=1e-9)
    assert found["length"].bound == near(0.001 / 16 + 20 * ROUND_OFF, rel=1e-9)
    two_levels = judged("constraint", of, fine, levels=LEVELS[1:])
    assert two_levels["length"].bound == near(9 / 256 + ROUND_OFF, rel=1e-9)
    assert judged("constraint", of, still)["velocity"].value == 0.0


# Quaternions, rest, flight


def test_an_attitude_is_off_unit_by_round_off_at_the_coarsest_level():
    spinning = Body(mass=1.0, inertia=(0.1,) * 3, omega=(0, 0, 1.0))
    of = instance([BALL, spinning])
    run = shifted(of, "attitude", 2, 1, (0.5, 0, 0, 0))
    found = judged("quaternion-norm", of, run)["norm"]
    assert found.value == 0.5
    assert found.bound == near(ROUND_OFF, rel=1e-14)
    fine = judged("quaternion-norm", of, run, levels=(2.0**-10, 2.0**-11))["norm"]
    assert fine.bound == near(8 * U * sqrt(8 * 1024), rel=1e-14)


def test_what_rests_moves_and_creeps_by_round_off_of_the_finest_level():
    resting = Body(mass=2.0, position=(3.0, 0, 0))
    of = instance([resting, resting], quantities={"x": 1.0})
    place = np.array(standing(of).position)
    place[2:, 1, 1] = (1.0, 2.0, 4.0)
    speed = np.zeros_like(place)
    speed[3, 0] = (0, 3.0, 4.0)
    run = standing(of, position=place, velocity=speed)
    known = truth(TIMES, {"x": [3.0] * 5})
    found = judged("rest", of, run, levels=(2.0**-3, 2.0**-11), known=known)
    assert (found["displacement"].value, found["speed"].value) == (1.0, 5 / 8)
    # From the third sample, 1 m away, to the last, 4 m away, in 4 s.
    assert "mean creep over the second half 0.75 m/s" in found["speed"].sentence
    for finding in found.values():
        assert finding.bound == near(8 * U * sqrt(2.0**14), rel=1e-14)


def test_a_body_in_flight_moves_by_its_velocity_to_the_roundings_of_places_and_ways():
    flying = Body(
        mass=2.0,
        inertia=(0.8,) * 3,
        velocity=(3.0, 0, 4.0),
        position=(0, 0, 2.0),
        shape=Sphere(radius=1.0),
    )
    of = instance([flying, SMALL], (SOFT,))
    place = np.array(standing(of).position)
    place[:, 0] += np.outer(TIMES, (3.0, 0, 4.0))
    place[2:, 0] += (0.3, 0.4, 0.0)
    run = standing(of, position=place)
    found = judged("flight", of, run)["way"]
    assert found.value == near(0.5 / 4, rel=1e-12)
    # |r| is 34 m at most, |v| 4 m/s in a component: 8.5 L and 8 L in 8 s; 64 steps a sample.
    expected = ROUND_OFF * (1 + 34 / 4 + 4 * 8 / 4) + 2 * U * 64 * 34 / 4
    assert found.bound == near(expected, rel=1e-12)
    assert found.sharpness == near(found.bound / (10 / 4), rel=1e-12)


def test_a_body_that_is_hit_or_goes_through_a_wall_is_not_in_flight():
    flying = Body(
        mass=2.0,
        inertia=(0.8,) * 3,
        velocity=(0.0, 0, -4.0),
        position=(0, 0, 10.0),
        shape=Sphere(radius=1.0),
    )
    of = instance([flying], (SOFT, Plane()))
    # It stands still although its velocity is kept: only the first way ends above the wall.
    found = judged("flight", of, standing(of))["way"]
    assert found.value == near(8 / 4)
    down = instance([flying], (SOFT, Plane(point=(0, 0, 1.0))))
    assert judged("flight", down, standing(down)) == {}


def test_a_velocity_that_a_graze_changes_by_less_than_half_of_round_off_is_that_of_flight():
    flying = Body(mass=2.0, inertia=(0.8,) * 3, velocity=(4.0, 0, 0.0), shape=Sphere(radius=1.0))
    of = instance([flying, SMALL], (SOFT,), times=(0.0, 8.0))
    for factor, flies in ((0.45, True), (0.55, False)):
        velocity = np.array(standing(of).velocity)
        velocity[1, 0, 1] += factor * ROUND_OFF * 4
        run = standing(of, velocity=velocity)
        free = discovery.check("flight")
        subject = Subject(of, method(), LEVELS, None)
        found = free.judge(subject, {subject.finest: CompletedRun(run, Cost(seconds=0.0))})
        assert (found[0].value > 1) == flies


# Angular momentum and momentum


def test_angular_momentum_that_is_claimed_changes_by_round_off_in_units_of_its_terms():
    of = instance([POINT], (CentralField(gm=1.0),))
    claims = method(conserves=frozenset({"angular-momentum"}))
    run = shifted(of, "velocity", 2, 0, (0, 1.0, 0))
    found = judged("angular-momentum", of, run, claims)["total"]
    # m r v = 24 kg m^2/s and 30; L is rounded on the scale of the larger one.
    assert found.value == near(6 / 24, rel=1e-14)
    assert found.bound == near(30 / 24 * ROUND_OFF, rel=1e-14)
    # Before that sample it is that of the start, and sharpness is told where it is least.
    assert found.sharpness == near(ROUND_OFF, rel=1e-14)


def test_angular_momentum_that_is_not_claimed_has_the_smaller_of_two_bounds_and_says_what_it_does():
    of = instance([POINT], (CentralField(gm=1.0),))
    coarse = shifted(of, "velocity", 2, 0, (0, 0.01, 0))
    fine = shifted(of, "velocity", 2, 0, (0, 0.001, 0))
    found = judged(
        "angular-momentum", of, lambda variant: coarse if variant.level == LEVELS[0] else fine
    )["total"]
    assert found.value == near(0.001 / 4, rel=1e-9)
    assert found.bound == near(4 * 0.01 / 4 / 16 + 20 * ROUND_OFF, rel=1e-9)
    assert (
        "it changes by 0.0025 at a step of 0.12 s and by 0.00025 at a step of 0.031 s"
        in found.sentence
    )
    loose = judged("angular-momentum", of, fine, levels=LEVELS[1:])["total"]
    assert loose.bound == near(9 / 256 + ROUND_OFF, rel=1e-9)


@pytest.mark.parametrize(("part", "is_reported"), [(19.0, False), (22.0, True)])
def test_angular_momentum_that_changes_by_round_off_is_not_told(part, is_reported):
    of = instance([POINT], (CentralField(gm=1.0),))
    run = shifted(of, "velocity", 2, 0, (0, 4 * part * ROUND_OFF, 0))
    found = judged("angular-momentum", of, run)["total"]
    assert ("No torque acts from outside" in found.sentence) == is_reported


def test_free_motion_keeps_orbital_angular_momentum_and_turns_add_to_the_spin():
    spinning = Body(
        mass=2.0,
        inertia=(1.0, 2.0, 2.0),
        position=(3.0, 0, 0),
        velocity=(0, 4.0, 0),
        omega=(0, 3.0, 0),
    )
    of = instance([spinning])
    h = LEVELS[0]
    found = judged(
        "angular-momentum",
        of,
        standing(of),
        method(conserves=frozenset({"angular-momentum"}), broken_with={}),
        levels=(h,),
    )
    flown = 64 * U
    turned = 3 * 64 * U
    # A body in flight goes as far as |v| T: the scale is 2 (3 + 32) 4 + 2 x 3.
    scale = 2 * 35 * 4 + 2 * 3
    assert found["orbital"].bound == near(ROUND_OFF + flown, rel=1e-14)
    for name, size in (("total", hypot(24, 6)), ("spin", 6)):
        assert found[name].bound == near(ROUND_OFF + flown + turned, rel=1e-14)
        assert found[name].sharpness == near(found[name].bound / (size / scale), rel=1e-13)
    assert found["orbital"].sharpness == near(found["orbital"].bound / (24 / scale), rel=1e-13)


def two_balls(branch="R", **more):
    """Two balls that rub, in a case that has truth for r, v and omega of both."""
    names = {
        f"{kind}{n}.{axis}": scale
        for kind, scale in (("r", 2.0), ("v", 4.0), ("omega", 8.0))
        for n in (1, 2)
        for axis in "xyz"
    }
    law = Contact(law="linear", stiffness=8.0, friction=0.5, branch=branch)
    first = Body(
        mass=2.0,
        inertia=(0.8,) * 3,
        velocity=(0, 3.0, 0),
        omega=(0, 0, 1.0),
        shape=Sphere(radius=1.0),
    )
    second = Body(
        mass=1.0,
        inertia=(0.1,) * 3,
        position=(0, 2.0, 0),
        velocity=(4.0, 0, 0),
        shape=Sphere(radius=0.5),
    )
    return instance([first, second], (law,), quantities=names)


def test_where_the_law_changes_angular_momentum_it_is_compared_with_truth_and_said():
    of = two_balls()
    bodies = of.scene.bodies
    values = {}
    for kind, column in (("r", bodies.position), ("v", bodies.velocity), ("omega", bodies.omega)):
        for n in (1, 2):
            for k, axis in enumerate("xyz"):
                values[f"{kind}{n}.{axis}"] = np.full(5, column[n - 1, k])
    # The law changes the spin of the first, in units of m |r| |v| + |J omega| = 8.8.
    values["omega1.z"] = np.array([1.0, 3.0, 4.0, 2.0, 2.0])
    known = truth(TIMES, values)
    run = shifted(of, "omega", 1, 0, (0, 0, 2.5))
    found = judged("angular-momentum", of, run, known=known)["law"]
    spins = np.array([1.0, 3.5, 1.0, 1.0, 1.0])
    level = LEVELS[-1]
    noise = ROUND_OFF + U * 256
    # Friction 1/2 that alternates, on a sphere of J = 2/5 m R^2: 5/4 of a normal force.
    bound = 1.25 * truncated(level) + noise
    # m |r| 4 + m |v| 2 of both, J 8: 2 (0 + 3 x 2) + 1 (2 x 4 + 4 x 2) + 0.9 x 8 of 8.8.
    allowed = (12 + 16 + 7.2) / 8.8 * bound
    values = 0.8 * np.abs(spins - [1, 3, 4, 2, 2]) / 8.8
    worst = int(np.argmax(values / allowed))
    assert found.value == near(values[worst], rel=1e-12)
    assert found.bound == near(allowed[worst], rel=1e-12)
    # 0.8 (4 - 1)/8.8, counted from the start.
    assert "The law itself changes it by 0.27" in found.sentence


def test_a_law_whose_lever_arms_add_up_is_held_to_constant_angular_momentum():
    of = two_balls(branch="R-d/2")
    known = truth(TIMES, {})
    found = judged("angular-momentum", of, standing(of), known=known)
    assert set(found) == {"total"}


# Apsides


def test_laplaces_vector_is_held_to_the_errors_of_place_and_velocity():
    of = instance([POINT], (CentralField(gm=48.0),))
    # v x (r x v)/gm - r/|r| = (48/48 - 1, 0, 0): a circle; then r = 4, v = 3: 36/48 - 1.
    place = np.array(standing(of).position)
    speed = np.array(standing(of).velocity)
    place[2, 0] = (4.0, 0, 0)
    speed[2, 0] = (0, 3.0, 0)
    run = standing(of, position=place, velocity=speed)
    h = 2.0**-9
    found = judged("apsides", of, run, levels=(h,))["laplace"]
    sharp = (2 * 3 * 4 * 8 + 9 * 4) / 48 + 4 / 4
    allowed = truncated(h)[2] + 8 * U * sqrt(8 / h)
    assert found.value == near(0.25, rel=1e-13)
    assert found.bound == near(sharp * allowed, rel=1e-12)
    least = ((2 * 4 * 3 * 8 + 16 * 4) / 48 + 4 / 3) * (truncated(h)[0] + 8 * U * sqrt(8 / h))
    assert found.sharpness == near(least, rel=1e-12)


def test_fradkins_tensor_is_held_to_the_errors_of_place_and_velocity():
    anchor = (1.0, 0.0, 0.0)
    of = instance([POINT], (Spring(a=0, b=-1, stiffness=3.0, anchor_b=anchor),))
    speed = np.array(standing(of).velocity)
    speed[2, 0] = (0, 5.0, 0)
    run = standing(of, velocity=speed)
    h = 2.0**-9
    found = judged("apsides", of, run, levels=(h,))["fradkin"]
    # 2 E0 = 2 x 16 + 3 x 4 = 44; T_yy = m v^2/(2 E0) goes from 32 to 50.
    sharp = 2 * (3 * 2 * 4 + 2 * 5 * 8) / 44
    assert found.value == near(18 / 44, rel=1e-13)
    assert found.bound == near(sharp * (truncated(h)[2] + 8 * U * sqrt(8 / h)), rel=1e-12)


def test_apsides_turn_by_the_angle_of_vectors_or_of_axes():
    from refdem.checks.apsides import turned

    vectors = np.array([[1.0, 0, 0], [0, 9.0, 0], [cos(2.5), sin(2.5), 0]])
    assert turned(vectors) == near(2.5, rel=1e-14)
    axes = [np.diag([4.0, 1.0, 0.5])]
    c, s = cos(0.5), sin(0.5)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    axes.append(rotation @ axes[0] @ rotation.T)
    assert turned(np.array(axes)) == near(0.5, rel=1e-13)


# Capture


def captured(
    factor=1.0, times=(0.0, 1.0, 2.0, 3.0, 4.0), radius=2.0, rate=0.5, hook=(0.0, 0.0, 0.0)
):
    """A point that circles a hook; the last speed is wrong by a factor."""
    point = Body(mass=3.0, position=(radius, 0, 0), velocity=(0, radius * rate, 0))
    catch = Catch(a=0, b=-1, radius=radius, anchor_b=hook)
    of = instance([point], (catch,), times=times, quantities={"x": 4.0})
    t = np.array(times)
    angle = rate * t
    place = radius * np.stack([np.cos(angle), np.sin(angle), 0 * t], axis=1)[:, None]
    speed = radius * rate * np.stack([-np.sin(angle), np.cos(angle), 0 * t], axis=1)[:, None]
    place = place + np.array(hook)
    speed[-1] *= factor
    known = truth(
        times,
        {"x": place[:, 0, 0]},
        growth=[1.0, 1.0, 2.0, 2.0, 2.0],
        scalars={"omega": (0.4, 0.0), "inertia": (10.0, 0.0)},
    )
    return judged(
        "capture", of, standing(of, position=place, velocity=speed), levels=(2.0**-9,), known=known
    )


def test_after_a_capture_rate_speed_and_inertia_agree():
    found = captured(factor=1.5)
    # The angles turn at 1/2 rad/s, truth says 0.4; v/(r omega) = 1.5; L/omega = 3 x 2 x 1.5/0.5
    # = 18, truth says 10.
    assert found["omega"].value == near(0.25, rel=1e-12)
    assert found["speed"].value == near(0.5, rel=1e-12)
    assert found["inertia"].value == near(0.8, rel=1e-12)
    h = 2.0**-9
    bound = 2 * (9 * (2 * h) ** 2 + 8 * U * sqrt(4 / h) + U * 4 / h)
    for finding in found.values():
        assert finding.bound == near(bound, rel=1e-9)
        assert finding.sharpness == near(bound, rel=1e-9)


def test_a_hook_may_be_anywhere():
    found = captured(factor=1.5, hook=(1.0, -2.0, 0.0))
    assert found["omega"].value == near(0.25, rel=1e-12)
    assert found["speed"].value == near(0.5, rel=1e-12)
    assert found["inertia"].value == near(0.8, rel=1e-12)


def test_whole_turns_between_samples_are_counted_by_the_speed():
    found = captured(rate=0.5 + 4 * pi)
    assert found["omega"].value == near((0.5 + 4 * pi) / 0.4 - 1, rel=1e-12)


def test_a_body_circles_where_its_velocity_is_across_to_a_part_in_a_thousand():
    from refdem.checks.capture import _is_circling

    arm = np.array([[2.0, 0, 0]] * 3)
    velocity = 5.0 * np.array([[0.0009, 1, 0], [-0.0011, 1, 0], [1.0, 0, 0]])
    assert _is_circling(arm, velocity).tolist() == [True, False, False]


# Equilibria


def pendulum(top, delta, angles, control="step"):
    """A point on a rod of 2 m under 8 m/s^2, so that w0 = 2/s, at angles from the vertical."""
    sign = 1.0 if top else -1.0
    times = (0.0, 0.25, 0.5)

    def place(a):
        return (2 * sin(a), 0.0, sign * 2 * cos(a))

    start = Body(mass=1.0, position=place(delta))
    of = instance(
        [start], (Rod(a=0, b=-1, length=2.0), UniformGravity(g=(0, 0, -8.0))), times=times
    )
    run = standing(of, position=[[place(a)] for a in angles])
    claims = method(control)
    level = 2.0**-9 if control == "step" else 1e-9
    return judged("equilibrium", of, run, claims, levels=(level,))


@pytest.mark.parametrize("control", ["step", "tolerance"])
def test_near_the_top_an_angle_grows_as_cosh_and_near_the_bottom_it_swings(control):
    delta = 0.02
    t = np.array((0.0, 0.25, 0.5))
    amplitude = delta if control == "step" else 1.0
    if control == "step":
        error = (1 + 2 * t) * (2.0**-8) ** 2 * amplitude + 8 * U * 16
    else:
        error = np.full(3, 1e-6) + 8 * U * 16
    wrong = 1.5 * delta
    found = pendulum(True, delta, (delta, wrong, delta * cosh(1)), control)["departure"]
    assert found.value == near(wrong - delta * cosh(0.5), rel=1e-9)
    third = delta**3 / 6 * (cosh(0.5) ** 3 / 8 + 3 * 0.5 * sinh(0.5) / 8)
    assert found.bound == near(1.1 * third + error[1] * cosh(0.5) * 1.5, rel=1e-9)
    low = pendulum(False, delta, (delta, -wrong, delta * cos(1)), control)
    assert low["bounded"].value == near(wrong - delta, rel=1e-9)
    assert low["bounded"].bound == near(error[1] * 1.5, rel=1e-9)
    assert low["swing"].value == near(wrong + delta * cos(0.5), rel=1e-9)
    third = delta**3 * (0.5 / 16 + 1 / 96)
    assert low["swing"].bound == near(1.1 * third + error[1] * 1.5, rel=1e-9)


def test_an_angle_is_followed_from_the_top_up_to_a_twentieth():
    # delta cosh(2 t): 0.03, 0.0338, 0.0463; 0.035, 0.0395, 0.054.
    assert pendulum(True, 0.03, (0.03, 0.03, 1.0))["departure"].value > 0.9
    assert pendulum(True, 0.035, (0.035, 0.0395, 1.0))["departure"].value < 1e-3


@pytest.mark.parametrize(("angle", "applies"), [(0.0499999, True), (0.0500001, False)])
def test_a_start_within_a_twentieth_is_near_an_equilibrium(angle, applies):
    start = Body(mass=1.0, position=(2 * sin(angle), 0.0, -2 * cos(angle)))
    of = instance([start], (Rod(a=0, b=-1, length=2.0), UniformGravity(g=(0, 0, -8.0))))
    said = discovery.check("equilibrium").applies(Subject(of, method(), LEVELS, None))
    assert (said is None) == applies


# Energy returned, stop, limit


def test_energy_gained_is_that_of_truth_and_is_returned():
    field = PiecewiseField(k1=1.0, k2=-1.0, x1=-1.0, x2=1.0)
    point = Body(mass=2.0, velocity=(4.0, 0, 0))
    of = instance([point], (field,), quantities={"vx": 8.0})
    speeds = [4.0, 5.0, 16.0, 9.0, 6.0]
    known = truth(TIMES, {"v": speeds, "vx": speeds}, growth=[1, 1, 1, 1, 3.0])
    forward = standing(of, velocity=[[[v, 0, 0]] for v in (4.0, 5.0, 16.0, 9.0, 7.0)])
    back = standing(of, velocity=[[[v, 0, 0]] for v in (7.0, 5.0, 16.0, 9.0, 5.0)])

    def found(**claims):
        h = 2.0**-9
        return judged(
            "energy-return",
            of,
            lambda v: back if v.change == "reversed" else forward,
            method(**claims),
            levels=(h,),
            known=known,
        )

    # The unit is 128 J x (16/8)^2; the run gains 49 - 16, truth 36 - 16; back it loses 49 - 25.
    h = 2.0**-9
    step = 3 * (17 * (2 * h) ** 2 + 8 * U * sqrt(8 / h) + U * 8 / h)
    plain = found()
    assert plain["gain"].value == near(13 / 512, rel=1e-12)
    assert plain["gain"].bound == near(2 * step, rel=1e-9)
    assert plain["return"].value == near(9 / 512, rel=1e-12)
    assert plain["return"].bound == near(2 * 2 * step * 3, rel=1e-9)
    exact = found(reversible=True)
    assert exact["return"].bound == near(2 * 2 * 8 * U * sqrt(8 / h) * 9, rel=1e-9)


def test_a_stop_is_where_and_when_truth_says_and_nothing_creeps_after_it():
    point = Body(mass=2.0)
    slider = Slider(a=0, friction=0.5, normal_force=1.0)
    of = instance([point], (SPRING, slider), quantities={"x": 4.0})
    known = truth(
        TIMES,
        {"x": [0.0, 1.0, 2.0, 2.0, 2.0]},
        growth=[1, 1, 1, 1, 2.0],
        scalars={"stop_time": (5.0, 0.0), "stop_position": (2.0, 0.125)},
    )
    run = standing(of, position=[[[x, 0, 0]] for x in (0, 1, 2, 3.0, 2.5)])
    h = 2.0**-9
    found = judged("stop", of, run, levels=(h,), known=known)
    bound = 2 * (17 * (2 * h) ** 2 + 8 * U * sqrt(8 / h) + U * 8 / h)
    assert found["stop_position"].value == pytest.approx(0.5 / 4 - 0.125, abs=1e-15)
    assert found["stop_position"].bound == near(bound, rel=1e-9)
    assert found["creep"].value == near(0.5 / 4, rel=1e-14)
    further = standing(of, position=[[[x, 0, 0]] for x in (0, 1, 2, 2.0, 4.0)])
    assert judged("stop", of, further, levels=(h,), known=known)["stop_position"].value == near(
        0.375
    )


def test_the_limit_of_small_steps_is_a_part_of_its_own_last_change():
    of = instance([POINT], (SPRING,), quantities={"x": 4.0})
    known = truth(TIMES, {"x": [0.0] * 5}, growth=[1, 1, 1, 1.5, 1.5])
    h = 2.0**-7

    def at(error):
        return standing(of, position=[[[0.0, 0, 0]]] * 3 + [[[4 * error, 0, 0]]] + [[[0.0, 0, 0]]])

    errors = {4 * h: 1.0e-3, 2 * h: 2.4e-4, h: 5.5e-5}
    found = judged(
        "limit", of, lambda v: at(errors[v.level]), levels=(4 * h, 2 * h, h), known=known
    )["state"]
    coarse = (4 * 2.4e-4 - 1e-3) / 3
    fine = (4 * 5.5e-5 - 2.4e-4) / 3
    floor = 3 * 1.5 * 8 * U * sqrt(8 / h)
    assert found.value == near(abs(fine), rel=1e-9)
    assert found.bound == near(4 / 7 * abs(fine - coarse) + floor, rel=1e-9)
    # Of first order all of the change is allowed: 4/3 of it would be more.
    slow = {4 * h: 1.0e-3, 2 * h: 4.9e-4, h: 2.4e-4}
    found = judged(
        "limit",
        of,
        lambda v: at(slow[v.level]),
        method(order=1),
        levels=(4 * h, 2 * h, h),
        known=known,
    )
    if found["state"].bound is not None:
        assert found["state"].bound == near(2e-5 - 1e-5 + floor, rel=1e-6)


def test_the_limit_of_small_steps_allows_what_the_printed_truth_is_rounded_by():
    of = instance([POINT], (SPRING,), quantities={"x": 4.0})
    h = 2.0**-7
    levels = (4 * h, 2 * h, h)

    def run(variant):
        return standing(of, position=[[[4 * 16 * variant.level**2, 0, 0]]] * 5)

    bounds = []
    for radius in (0.0, 1e-6):
        known = truth(TIMES, {"x": [0.0] * 5}, radius=radius)
        bounds.append(judged("limit", of, run, levels=levels, known=known)["state"].bound)
    assert bounds[1] - bounds[0] == near(1e-6 / 4, rel=1e-6)


@pytest.mark.parametrize(
    ("errors", "outcome"), [((1e-3, 3.0e-4, 8e-5), "fail"), ((1e-3, 3.1e-4, 8e-5), "undecided")]
)
def test_errors_fall_with_the_order_less_three_tenths_or_are_left_to_the_order(errors, outcome):
    # log2(10/3) = 1.737, log2(10/3.1) = 1.69: the order 2 less 0.3 is 1.7.
    of = instance([POINT], (SPRING,), quantities={"x": 4.0})
    known = truth(TIMES, {"x": [0.0] * 5})
    h = 2.0**-7
    levels = (4 * h, 2 * h, h)

    def run(variant):
        error = 4 * errors[levels.index(variant.level)]
        return standing(of, position=[[[error, 0, 0]]] * 5)

    found = judged("limit", of, run, levels=levels, known=known)["state"]
    assert (found.outcome == "undecided") == (outcome == "undecided")


# Contact line, lyapunov, flips, phases


def test_bodies_gas_and_law_give_packing_contact_time_and_restitution():
    from refdem.checks import cooling, roughness

    box = PeriodicBox(size=10.0)
    law = Contact(law="linear", stiffness=50.0, damping=3.0)
    balls = [
        Body(mass=2.0, inertia=(0.2,) * 3, position=(float(k), 0, 0), shape=Sphere(radius=0.5))
        for k in range(0, 10, 2)
    ]
    scene = instance(balls, (law, box)).scene
    gas = cooling._gas(scene, 0.25)
    b = 1.5
    w = sqrt(2 * 50 / 2 - b * b)
    assert (gas.n, gas.frequency) == (5, 0.25)
    assert gas.packing == near(4 / 3 * pi * 5 * 0.125 / 1000, rel=1e-13)
    assert gas.lasts == near(pi / w, rel=1e-13)
    assert gas.restitution == near(exp(-pi * b / w), rel=1e-13)
    assert gas.softness == near(0.25 * pi / w, rel=1e-13)
    elastic = cooling._gas(instance(balls, (SOFT, box)).scene, 0.25)
    assert (elastic.restitution, elastic.lasts) == (1.0, near(pi / sqrt(8.0)))
    rigid = cooling._gas(instance(balls, (Contact(law="rigid", restitution=0.75), box)).scene, 0.25)
    assert (rigid.restitution, rigid.lasts) == (0.75, 0.0)
    sluggish = cooling._gas(
        instance(balls, (Contact(law="linear", stiffness=1.0, damping=9.0), box)).scene, 0.25
    )
    assert (sluggish.lasts, sluggish.restitution) == (inf, 0.0)
    packing, softness = roughness._packing_and_softness(instance(balls, (SOFT, box)).scene, 0.25)
    assert packing == near(gas.packing, rel=1e-13)
    assert softness == near(0.25 * pi * sqrt(2 / 16), rel=1e-13)
    assert roughness._inertia(scene) == near(0.4, rel=1e-13)


@pytest.mark.parametrize(
    ("packing", "lasts", "restitution", "word"),
    [
        (0.1, 0.05, 0.5, None),
        (0.101, 0.01, 0.9, "not dilute"),
        (0.01, 0.0501, 0.9, "binary"),
        (0.01, 0.01, 0.499, "too far from 1"),
    ],
)
def test_kinetic_theory_holds_up_to_its_limits(packing, lasts, restitution, word):
    from refdem.checks.cooling import Gas

    doubt = Gas(100, restitution, lasts, packing, 1.0).doubt()
    assert (doubt is None) if word is None else (word in doubt)


def test_a_mean_over_collisions_weighs_intervals_by_their_collisions():
    from refdem.checks.cooling import _mean_over_collisions

    found = _mean_over_collisions(np.array([4.0, 1.0, 4.0]), np.array([0.0, 3.0, 4.0]))
    assert found == 2.0
    assert _mean_over_collisions(np.array([4.0, 1.0, 9.0]), np.array([0.0, 3.0, 4.0])) == 9 / 4


def test_neighbours_are_followed_up_to_a_hundredth_and_flips_skip_zeros():
    from refdem.checks.flips import _flips
    from refdem.checks.lyapunov import _until_saturated

    assert _until_saturated(np.array([1e-8, 0.01, 0.0100001, 1e-9])) == 2
    assert _until_saturated(np.array([1e-8, 0.01])) == 2
    assert _flips(np.array([1.0, 0.0, 2.0, -1.0, 0.0, -3.0, 4.0])) == 2
    assert _flips(np.array([0.0, -1.0])) == 0


def test_an_outline_has_the_roundings_of_its_length_and_the_error_of_its_polygon():
    from refdem.checks import phase_area

    # A square of side 2 about the origin, in eight points.
    x = np.array([[1, 1, 1, 0, -1, -1, -1, 0.0]])
    v = np.array([[-1, 0, 1, 1, 1, 0, -1, -1.0]])
    subject = Subject(instance([POINT]), method(), LEVELS, None)
    # The length in x is 4, and in v: 8 roundings of 1 x 4 + 1 x 4.
    assert phase_area.rounding(subject, x, 2 * v)[0] == near(8 * ROUND_OFF * (2 * 4 + 1 * 8))
    # Half of the points are the square, of area 4; a quarter of them are two: area 0.
    assert phase_area.polygon(x, v, 0.45)[0] == near(0.45 * 4)
    larger = phase_area.polygon(np.vstack([2 * x, x]), np.vstack([v, v]), 4.0)
    assert larger.tolist() == [32.0, 32.0]


# Contact channels


def touching_balls(damping=2.0, **run):
    """Two balls of 2 and 1 kg whose overlap is 1/2 and 1/4 m and nothing."""
    law = Contact(law="linear", stiffness=8.0, damping=damping)
    of = instance([BALL, SMALL], (law,), times=(0.0, 4.0, 8.0))
    place = [[[0, 0, 0], [d, 0, 0]] for d in (1.0, 1.25, 3.0)]
    speed = [[[1.0, 0, 0], [0, 0, 0]], [[-0.25, 0, 0], [0.25, 0, 0]], [[0, 0, 0], [1.0, 0, 0]]]
    return of, lambda **channels: standing(
        of, position=place, velocity=speed, channels={k: np.array(x) for k, x in channels.items()}
    )


def test_channels_of_contact_follow_from_the_state_of_their_row():
    of, run = touching_balls()
    # F = 8 d + 2 d': 6, 1 and 0 N.
    exact = judged(
        "contact-channels", of, run(overlap=[0.5, 0.25, 0.0], contact_force=[6.0, 1.0, 0.0])
    )
    assert exact["overlap"].value == exact["contact_force"].value == 0.0
    wrong = judged(
        "contact-channels", of, run(overlap=[0.5, 0.75, 0.0], contact_force=[6.0, 4.0, 0.0])
    )
    assert wrong["overlap"].value == 0.5 / 4
    reach = 3.0 + 2 * 1.0
    of_overlap = ROUND_OFF + 4 * U * reach / 4
    assert wrong["overlap"].bound == near(of_overlap, rel=1e-12)
    # Half a step earlier, h = 1/32 s, m_eff = 2/3 kg: F/(1 - c h/(2 m_eff)) is nearer to 4 N.
    earlier = 1.0 / (1 - 2.0 / 32 / (2 * 2 / 3))
    assert wrong["contact_force"].value == near((4.0 - earlier) / 6, rel=1e-12)
    of_force = ROUND_OFF + of_overlap * 4 / 0.5 + 8 * U * 2 * 1.0 / 6
    assert wrong["contact_force"].bound == near(of_force, rel=1e-12)
    pulling = judged("contact-channels", of, run(contact_force=[6.0, 1.0, -5.0]))
    assert pulling["contact_force"].value == 0.0


def test_a_force_of_half_a_step_earlier_is_right_and_of_more_bodies_it_may_be_off_by_its_change():
    of, run = touching_balls()
    earlier = [f / (1 - 2.0 / 32 / (2 * 2 / 3)) for f in (6.0, 1.0, 0.0)]
    found = judged("contact-channels", of, run(contact_force=earlier))["contact_force"]
    assert found.value == pytest.approx(0.0, abs=1e-15)
    # A tolerance is no step, and has no half of one.
    loose = judged("contact-channels", of, run(contact_force=earlier), method("tolerance"))
    assert loose["contact_force"].value == near((earlier[0] - 6.0) / 6, rel=1e-12)
    law = Contact(law="linear", stiffness=8.0, damping=2.0)
    third = Body(mass=2.0, inertia=(0.1,) * 3, position=(0, 9.0, 0), shape=Sphere(radius=0.5))
    three = instance([BALL, SMALL, third], (law,), times=(0.0, 8.0))
    still = standing(
        three,
        position=[[[0, 0, 0], [1.0, 0, 0], [0, 9.0, 0]]] * 2,
        channels={"contact_force": np.array([4.0, 5.0])},
    )
    loose = judged("contact-channels", three, still)["contact_force"]
    # c h/m_eff = 2/32/(2/3) of the largest force, relative to it.
    reach = 9.0 + 2.0
    rounding = ROUND_OFF + (ROUND_OFF + 4 * U * reach / 4) * 4 / 0.5
    assert loose.value == near(1 / 4)
    assert loose.bound == near(2 / 32 * 3 / 2 + rounding, rel=1e-12)


# Contact line


def rolling(factor=1.0, control="step", levels=(2.0**-9,), slope=0.0):
    """A ball of 2 kg, J = 0.8, that slides on a plane under 10 m/s^2 with friction 1/4."""
    law = Contact(law="rigid", friction=0.25)
    ball = Body(
        mass=2.0,
        inertia=(0.8,) * 3,
        position=(0, 0, 1.0),
        velocity=(6.0, 0, 0),
        shape=Sphere(radius=1.0),
    )
    gravity = UniformGravity(g=(slope, 0, -10.0))
    of = instance([ball], (law, Plane(), gravity), times=(0.0, 0.25, 0.5))
    t = np.array((0.0, 0.25, 0.5))
    # v' = g_x - mu g, and J w' = m R mu g about y, up to a factor.
    speed = np.zeros((3, 1, 3))
    spin = np.zeros((3, 1, 3))
    speed[:, 0, 0] = 6.0 + (slope - 2.5) * t
    spin[:, 0, 1] = factor * 2.5 * 2 / 0.8 * t
    run = standing(of, velocity=speed, omega=spin)
    return judged(
        "contact-line",
        of,
        run,
        method(control, conserves=frozenset({"angular-momentum"})),
        levels=levels,
    )["moment"]


@pytest.mark.parametrize("slope", [0.0, 1.5])
def test_no_friction_has_a_moment_about_the_line_of_contact(slope):
    assert rolling(slope=slope).value == pytest.approx(0.0, abs=1e-14)
    wrong = rolling(factor=0.5, slope=slope)
    # J w lacks a half of 5 t; the size is m R v + m R g_x T = 12 + 2 g_x 0.5.
    size = 12 + 2 * slope * 0.5
    assert wrong.value == near(2.5 * 0.5 / size, rel=1e-12)
    steps = 0.5 * 2**9
    assert wrong.bound == near(8 * U * 16 + U * steps, rel=1e-12)
    assert wrong.sharpness == near(wrong.bound / (2.5 * 0.5 / size), rel=1e-12)


def test_what_runs_of_two_levels_need_is_the_coarsest_where_angular_momentum_is_claimed():
    check = discovery.check("contact-line")
    of = instance([BALL], (SOFT, Plane()))
    claims = method(conserves=frozenset({"angular-momentum"}))
    assert check.needs(Subject(of, claims, LEVELS, None)) == (Variant(LEVELS[0]),)
    assert check.needs(Subject(of, method(), LEVELS, None)) == (
        Variant(LEVELS[0]),
        Variant(LEVELS[-1]),
    )


# The top


@pytest.mark.parametrize("anchor", [(0.0, 0.0, 0.0), (1.0, -2.0, 0.5)])
def test_angular_momenta_of_a_top_are_about_its_joint(anchor):
    from refdem.checks import top

    body = Body(
        mass=2.0,
        inertia=(3.0, 3.0, 1.0),
        velocity=(0.0, 5.0, 0.0),
        omega=(0, 0, 4.0),
        position=(anchor[0] + 0.75, anchor[1], anchor[2] + 1.0),
    )
    joint = BallJoint(a=0, b=-1, anchor_a=(0.0, 0.0, -1.25), anchor_b=anchor)
    of = instance([body], (joint, UniformGravity(g=(0, 0, -2.0))))
    spins = top._spins(of.scene, standing(of))
    # About the vertical, downwards: -(J_3 w + m (x v_y)) = -(4 + 2 x 3/4 x 5).
    np.testing.assert_allclose(spins["L_z"], [-11.5] * 5, rtol=1e-13)
    np.testing.assert_allclose(spins["L_3"], [4.0] * 5, rtol=1e-13)
    opening, speed = top._opening(of.scene, standing(of))
    # The tip is at (3/4, 0, -1/4) from the anchor; w x arm is 0.
    np.testing.assert_allclose(opening, [sqrt(0.625)] * 5, rtol=1e-13)
    np.testing.assert_allclose(speed, [5.0] * 5, rtol=1e-13)


def test_a_top_is_held_to_round_off_or_to_the_smaller_of_two_bounds():
    body = Body(mass=2.0, inertia=(3.0, 3.0, 1.0), omega=(0, 0, 4.0), position=(0, 0, 1.25))
    joint = BallJoint(a=0, b=-1, anchor_a=(0.0, 0.0, -1.25))
    of = instance([body], (joint, UniformGravity(g=(0, 0, -2.0))))
    coarse = shifted(of, "omega", 2, 0, (0, 0, 0.04))
    fine = shifted(of, "omega", 2, 0, (0, 0, 0.004))
    claims = method(conserves=frozenset({"angular-momentum"}))
    found = judged("top", of, lambda v: coarse if v.level == LEVELS[0] else fine, claims)
    # L_z and L_3 are 4 to 4.04: both in units of the largest.
    assert found["L_z"].value == near(0.04 / 4.04, rel=1e-9)
    assert found["L_3"].value == near(0.004 / 4.004, rel=1e-9)
    assert found["L_3"].bound == near(4 * 0.04 / 4.04 / 16 + 20 * ROUND_OFF, rel=1e-9)
    lifted = shifted(of, "position", 2, 0, (0, 0, 0.5))
    opened = judged("top", of, lifted)
    assert opened["joint"].value == near(0.5 / 4, rel=1e-12)
    assert opened["joint velocity"].value == 0.0
