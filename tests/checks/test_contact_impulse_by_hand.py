"""The impulse between two samples, and what it may be off by, with numbers that are computed on
paper: of a sphere of 2 kg and radius 1 m over a wall, and of two spheres.
"""

from math import atan, pi, sqrt

import numpy as np
import pytest

from refdem.checks import contact_impulse
from refdem.checks.contact_impulse import CHECK
from refdem.core.check import Subject
from refdem.core.variant import Variant
from refdem.scene import Body, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from tests.handmade import U, findings, instance, method, near, standing

BALL = Body(mass=2.0, inertia=(0.8, 0.8, 0.8), position=(0.0, 0.0, 2.0), shape=Sphere(radius=1.0))
OTHER = Body(mass=4.0, inertia=(0.8, 0.8, 0.8), position=(2.5, 0.0, 0.0), shape=Sphere(radius=0.5))
LINEAR = Contact(law="linear", stiffness=8.0, damping=2.0)
TIMES = tuple(0.25 * k for k in range(8))


def over_wall(law, heights=None, velocities=None, omegas=None):
    """An instance, and a run of the ball at these heights [m] with these velocities (T, 3)."""
    count = len(heights) if heights is not None else len(velocities)
    of = instance([BALL], (law, Plane()), times=TIMES[:count])
    columns = {}
    if heights is not None:
        columns["position"] = [[[0.0, 0.0, z]] for z in heights]
    if velocities is not None:
        columns["velocity"] = [[list(v)] for v in velocities]
    if omegas is not None:
        columns["omega"] = [[list(w)] for w in omegas]
    return of, standing(of, **columns)


@pytest.mark.parametrize(
    ("law", "overlap", "rate", "force"),
    [
        (LINEAR, 0.25, 0.5, 3.0),
        (LINEAR, 0.25, -2.0, -2.0),
        (Contact(law="linear", stiffness=8.0, damping=2.0, cutoff="zero_force"), 0.25, -2.0, 0.0),
        (Contact(law="hertz", stiffness=8.0), 0.25, 9.0, 1.0),
        (LINEAR, 0.0, 5.0, 0.0),
        (LINEAR, -0.25, 5.0, 0.0),
    ],
)
def test_the_normal_force_is_that_of_the_law(law, overlap, rate, force):
    found = contact_impulse._normal_force(law, np.array([overlap]), np.array([rate]))
    assert found.tolist() == [force]


STEP = 0.0625
"""The coarsest step [s] of `subject_of`."""


def contact_of(of, run):
    """What the check sees of the contact in a run with this step."""
    return contact_impulse._Contact.of(subject_of(of), run, STEP)


def test_next_to_a_touch_the_force_may_be_that_of_the_dashpot_alone():
    force = np.array([0.0, 0.0, 0.0, 12.0, -2.0, 20.0, 22.0, -8.0])
    dashpot = np.array([2.0, 4.0, 6.0, 8.0, -10.0, 12.0, 14.0, -16.0])
    begins = np.array([False, True, True, True, False, False, False])
    found = contact_impulse._force_at_touch(begins, dashpot, force)
    assert found.tolist() == [0.0, 4.0, 6.0, 8.0, -10.0, 20.0, 22.0, -8.0]


def test_a_contact_begins_or_ends_around_samples_that_touch_and_others_that_do_not():
    of, run = over_wall(LINEAR, heights=[1.5, 1.5, 1.5, 1.5, 0.75, 0.75, 0.75, 0.75])
    expected = [False, False, True, True, True, False, False]
    assert contact_of(of, run).begins_or_ends.tolist() == expected
    pulling = over_wall(LINEAR, heights=[0.75] * 2, velocities=[(0, 0, 0.5), (0, 0, -0.5)])
    assert contact_of(*pulling).dashpot.tolist() == [-1.0, 1.0]
    cut = Contact(law="linear", stiffness=8.0, damping=2.0, cutoff="zero_force")
    pushing = over_wall(cut, heights=[0.75] * 2, velocities=[(0, 0, 0.5), (0, 0, -0.5)])
    assert contact_of(*pushing).dashpot.tolist() == [0.0, 1.0]


@pytest.mark.parametrize("precision", ["double", "single"])
def test_an_overlap_of_a_rounding_is_a_contact_or_none(precision):
    unit = {"double": 2.0**-53, "single": 2.0**-24}[precision]
    heights = [1.0 - 2 * unit, 0.75, 0.75, 0.75]
    of, run = over_wall(LINEAR, heights=heights, velocities=[(0, 0, -1.0)] * 4)
    subject = Subject(of, method(precision=precision), (STEP, STEP / 2), None)
    contact = contact_impulse._Contact.of(subject, run, STEP)
    assert contact.surely_touches.tolist() == [False, True, True, True]
    assert contact.may_touch.tolist() == [True] * 4
    low, high = contact.normal_force_nearby
    # A rounded overlap acts with c d' = 2 N or not at all; 1/4 m with k d + c d' = 4 N.
    assert low.tolist() == [0.0, 0.0, 2.0]
    assert high.tolist() == [4.0] * 3
    deeper, deep_run = over_wall(LINEAR, heights=[1.0 - 64 * unit] * 4)
    judged = Subject(deeper, method(precision=precision), (STEP, STEP / 2), None)
    assert contact_impulse._Contact.of(judged, deep_run, STEP).surely_touches.all()


def test_a_dashpot_may_see_the_velocity_of_another_step():
    # The closing speed rises by 1 m/s in 1/4 s: c |d''| h = 2 x 4 x 1/16 N, and by the law
    # F/m = (2 + 4)/2 = 3 m/s^2 at the most, less than 4.
    rates = [(0, 0, -1.0), (0, 0, -2.0)]
    of, run = over_wall(LINEAR, heights=[0.75] * 2, velocities=rates)
    assert contact_of(of, run).change_of_dashpot.tolist() == [0.5]
    # Without any change that is seen, the law says F/m = (2 + 4)/2.
    of, run = over_wall(LINEAR, heights=[0.75] * 2, velocities=[(0, 0, -2.0)] * 2)
    assert contact_of(of, run).change_of_dashpot.tolist() == [2 * 3 * STEP]


def test_a_step_of_friction_changes_the_slip_of_a_sphere_by_its_mass_and_inertia():
    # mu F h (1/m + R^2/J) = 1/2 x 2 N x h (1/2 + 1/0.8).
    of, run = over_wall(SLIDER, heights=[0.75] * 2)
    changed = contact_of(of, run).slip_change_of_step
    np.testing.assert_allclose(changed, [STEP * (0.5 + 1.25)], rtol=1e-15)
    # A slip of up to two such steps is that of a sphere that rolls.
    for speed, slides in ((3.4 * STEP, False), (3.6 * STEP, True)):
        of, run = over_wall(SLIDER, heights=[0.75] * 2, velocities=[(speed, 0, 0)] * 2)
        assert contact_of(of, run).slides_throughout.tolist() == [slides]


def test_four_samples_are_around_an_interval_and_fewer_at_the_ends():
    values = np.array([1.0, 5.0, 2.0, 0.0, 3.0])
    assert contact_impulse._extreme_nearby(values, np.maximum).tolist() == [5.0, 5.0, 5.0, 3.0]
    assert contact_impulse._extreme_nearby(values, np.minimum).tolist() == [1.0, 0.0, 0.0, 0.0]


def test_overlap_closing_speed_and_normal_of_a_wall_and_of_two_spheres():
    of, run = over_wall(LINEAR, heights=[1.75, 0.75], velocities=[(3.0, 0, -2.0), (0, 0, 1.0)])
    overlap, rate, normal = contact_impulse._contact_geometry(of.scene, run)
    assert overlap.tolist() == [-0.75, 0.25]
    assert rate.tolist() == [2.0, -1.0]
    assert normal.tolist() == [[0.0, 0.0, -1.0]] * 2
    pair = instance([BALL, OTHER], (LINEAR,), times=TIMES[:2])
    meeting = standing(
        pair,
        position=[[[0, 0, 0], [3, 4, 0]], [[0, 0, 0], [0, 0, 1.25]]],
        velocity=[[[1, 0, 0], [0, -2, 0]], [[0, 0, 0], [7, 0, 1]]],
    )
    overlap, rate, normal = contact_impulse._contact_geometry(pair.scene, meeting)
    assert overlap.tolist() == [-3.5, 0.25]
    np.testing.assert_allclose(rate, [0.6 + 1.6, -1.0], rtol=1e-15)
    np.testing.assert_allclose(normal, [[0.6, 0.8, 0.0], [0.0, 0.0, 1.0]], rtol=1e-15)


def test_an_impulse_is_split_along_the_mean_normal_and_the_turn_is_an_angle():
    of, run = over_wall(LINEAR, velocities=[(1.0, 0, 0), (0.0, 0, 0), (0.0, 0.0, 0.0)])
    normal = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 1.0, 0]])
    push, across, turn = contact_impulse._impulses(of.scene, run, normal)
    np.testing.assert_allclose(push, [sqrt(2.0), 0.0], rtol=1e-15)
    np.testing.assert_allclose(across, [sqrt(2.0), 0.0], rtol=1e-15)
    np.testing.assert_allclose(turn, [pi / 2, 0.0], rtol=1e-15)
    opposite = contact_impulse._impulses(
        of.scene, run, np.array([[1.0, 0, 0], [-0.6, 0.8, 0], [0, 1.0, 0]])
    )
    np.testing.assert_allclose(opposite[2], [pi - atan(4 / 3), atan(3 / 4)], rtol=1e-14)


def test_the_distance_from_the_friction_cone_is_measured_across_its_side():
    rubbing = Contact(law="linear", stiffness=8.0, friction=0.75)
    # On the ball, 2 kg: J = (2, 0, 1) is outside, (1.5, 0, 2) is on the cone, (0, 0, -1) pulls.
    velocities = np.cumsum([(0, 0, 0), (1, 0, 0.5), (0.75, 0, 1), (0, 0, -0.5)], axis=0)
    of, run = over_wall(rubbing, heights=[0.9] * 4, velocities=velocities)
    found = contact_impulse._outside_cone(contact_of(of, run))
    np.testing.assert_allclose(found, [2 * 0.8 - 0.6, 0.0, 0.6], atol=1e-15)


def test_the_cone_is_wider_by_the_turn_of_the_normal_and_at_most_a_half_space():
    rubbing = Contact(law="linear", stiffness=8.0, friction=1.0)
    pair = instance([BALL, OTHER], (rubbing,), times=TIMES[:2])

    def outside(turn, impulse):
        """Normals `turn` apart, half of it on either side of x, and the impulse on the first."""
        half = turn / 2
        places = (
            [[0, 0, 0], [np.cos(half), np.sin(half), 0]],
            [[0, 0, 0], [np.cos(half), -np.sin(half), 0]],
        )
        moved = [[[0.0] * 3] * 2, [[c / 2.0 for c in impulse], [0.0] * 3]]
        run = standing(pair, position=places, velocity=moved)
        return float(contact_impulse._outside_cone(contact_of(pair, run))[0])

    # The half angle is 45 degrees and the turn: J = (-1, 0, 4) is 4 cos - sin outside.
    for turn in (0.0, 0.125, 0.5):
        half_angle = pi / 4 + turn
        expected = 4 * np.cos(half_angle) - np.sin(half_angle)
        assert outside(turn, (-1.0, 0.0, 4.0)) == near(expected, rel=1e-13)
    assert outside(1.5, (-1.0, 0.0, 2.0)) == 0.0
    assert outside(1.5, (1.0, 0.0, 2.0)) == near(1.0, rel=1e-13)


@pytest.mark.parametrize(
    ("law", "pushing"),
    [
        # Overlaps 0, 0, 1/4, 1/4, 0; rates 1, 1, 1, -2, -2. The force pulls at the fourth sample.
        (LINEAR, [False, True, False, False]),
        (
            Contact(law="linear", stiffness=8.0, damping=2.0, cutoff="zero_force"),
            [False, True, True, True],
        ),
        (Contact(law="linear", stiffness=8.0), [False, True, True, True]),
    ],
)
def test_intervals_push_that_have_a_contact_and_a_touch_without_overlap_is_none(law, pushing):
    velocities = [(0, 0, -1)] * 3 + [(0, 0, 2)] * 2
    of, run = over_wall(law, heights=[1.0, 1.0, 0.75, 0.75, 1.0], velocities=velocities)
    assert contact_of(of, run).pushes_throughout.tolist() == pushing


@pytest.mark.parametrize(("branch", "arm"), [("R", 1.0), ("R-d/2", 0.875), ("R-d", 0.75)])
def test_a_sphere_slides_where_its_slip_outlasts_its_change(branch, arm):
    law = Contact(law="linear", stiffness=8.0, friction=0.5, branch=branch)
    # The slip is v - arm w for a spin about y: 4, 2, 1 m/s, then 0.9 m/s the other way, and across.
    slips = np.array([(4.0, 0), (2.25, 0), (1.0, 0), (-0.9, 0), (0.0, 5.0), (3.0, 4.0)])
    spins = [(0.0, 1.0, 0.0)] * 6
    velocities = [(s + arm, t, 0.3) for s, t in slips]
    of, run = over_wall(law, heights=[0.75] * 6, velocities=velocities, omegas=spins)
    contact = contact_of(of, run)
    # 2.25 > 1.75; 1 < 1.25; 0.9 < 1.9; 0.9 < 5.08; 5 > sqrt(10).
    assert contact.slides_throughout.tolist() == [True, False, False, False, True]
    np.testing.assert_allclose(
        contact.slip_turn, [0, 0, pi, pi / 2, atan(3 / 4)], rtol=1e-14, atol=1e-14
    )


def test_a_sphere_that_leaves_has_its_whole_radius_for_an_arm():
    law = Contact(law="linear", stiffness=8.0, friction=0.5, branch="R-d")
    # At height 3/2 the overlap is -1/2: the arm stays 1, so that spin and velocity cancel.
    of, run = over_wall(
        law, heights=[1.5] * 2, velocities=[(2.0, 0, 0)] * 2, omegas=[(0.0, 2.0, 0.0)] * 2
    )
    contact = contact_of(of, run)
    assert contact.slip.tolist() == [[0.0] * 3] * 2
    assert contact.slides_throughout.tolist() == [False]


@pytest.mark.parametrize(
    ("stride", "dense"), [(128, 32), (64, 16), (512, 64), (12, 2), (6, 1), (20, 4), (8, 2), (7, 1)]
)
def test_samples_are_four_steps_apart_or_a_64th_of_the_interval(stride, dense):
    of = instance([BALL], (LINEAR, Plane()), times=(0.0, 2.0, 4.0))
    level = 2.0 / stride
    expected = Variant(level)
    if dense > 1:
        expected = Variant(level, "denser_output", dense)
    assert CHECK.needs(Subject(of, method(), (level, level / 2), None)) == (expected,)


def subject_of(of):
    """A subject whose coarsest step is a fourth of the interval: 8 roundings of a phase of 16."""
    return Subject(of, method(), (0.0625, 0.03125), None)


ROUNDING = 8 * 8 * U * 16
"""TERMS times the round-off at any level of these: T/tau = 16 is above the root of the steps."""


def test_the_cone_is_held_to_eight_round_offs_and_more_for_fast_bodies():
    rubbing = Contact(law="linear", stiffness=8.0, friction=0.75)
    # The unit is m L/tau = 16 kg m/s; J = (2, 0, 1) is 1 kg m/s outside.
    of, run = over_wall(
        rubbing, heights=[0.9] * 3, velocities=[(0, 0, 0), (1, 0, 0.5), (1, 0, 0.5)]
    )
    cone = findings(CHECK, subject_of(of), run)["cone"]
    assert cone.value == near(1 / 16, rel=1e-14)
    # Without slip at the start, friction of one step, 3/4 x 0.8 N x h, may have any direction.
    of_step = 0.75 * 0.8 * STEP / 16
    assert cone.bound == near(of_step + ROUNDING, rel=1e-14)
    fast = standing(of, position=run.position, velocity=run.velocity + np.array([0.0, 24.0, 0.0]))
    assert findings(CHECK, subject_of(of), fast)["cone"].bound == near(3 * ROUNDING)
    lifted = standing(
        of, position=run.position + np.array([0.0, 0.0, 0.25]), velocity=fast.velocity
    )
    assert "cone" not in findings(CHECK, subject_of(of), lifted)


def test_a_sphere_that_only_touches_has_no_cone():
    rubbing = Contact(law="linear", stiffness=8.0, friction=0.75)
    of, run = over_wall(rubbing, heights=[1.0] * 3, velocities=[(1, 0, 0)] * 3)
    assert set(findings(CHECK, subject_of(of), run)) == {"normal"}


def test_sliding_is_held_to_round_off_and_to_what_the_slip_turns():
    law = Contact(law="linear", stiffness=8.0, friction=0.5)
    # J = 2 (0, -1/2, 1/2): J_n = 1, J_t = 1; the slip turns from (6, 0) to (6, -1/2).
    of, run = over_wall(law, heights=[0.9] * 2, velocities=[(6.0, 0, 0), (6.0, -0.5, 0.5)])
    sliding = findings(CHECK, subject_of(of), run)["sliding"]
    turn = atan(1 / 12)
    assert sliding.value == near((1 - 0.5) / 16, rel=1e-14)
    assert sliding.bound == near(ROUNDING * 1.5 + 0.5 * turn / 16, rel=1e-12)


@pytest.mark.parametrize(
    ("law", "found"),
    [
        (Contact(law="linear", stiffness=8.0, friction=0.5), {"normal", "cone", "sliding"}),
        (Contact(law="linear", stiffness=8.0), {"normal"}),
        (
            Contact(law="linear", stiffness=8.0, friction=0.5, tangential_stiffness=1.0),
            {"normal"},
        ),
    ],
)
def test_sliding_and_cone_are_those_of_friction_without_a_spring(law, found):
    of, run = over_wall(law, heights=[0.9] * 2, velocities=[(6.0, 0, 0), (6.0, -0.5, 0.5)])
    assert set(findings(CHECK, subject_of(of), run)) == found


def test_two_spheres_have_a_cone_and_are_not_held_to_sliding():
    law = Contact(law="linear", stiffness=8.0, friction=0.5)
    pair = instance([BALL, OTHER], (law,), times=TIMES[:2])
    places = [[[0, 0, 0], [1.25, 0, 0]]] * 2
    run = standing(pair, position=places, velocity=[[[0, 9.0, 0], [0.0] * 3]] * 2)
    assert set(findings(CHECK, subject_of(pair), run)) == {"normal", "cone"}


def normal_of(of, run):
    """The finding on the normal impulse."""
    return findings(CHECK, subject_of(of), run)["normal"]


def test_within_a_contact_the_normal_impulse_may_leave_the_forces_by_their_curvature():
    # k d = 8 x 1/4 = 2 N at every sample; the interval is 1/4 s, and J = 2 (1/2) is 1/2 too much.
    law = Contact(law="linear", stiffness=8.0)
    of, run = over_wall(law, heights=[0.75] * 5, velocities=[(0, 0, 0)] * 2 + [(0, 0, 0.5)] * 3)
    found = normal_of(of, run)
    assert found.value == near((1.0 - 0.5) / 16, rel=1e-14)
    # F dt (dt/tau)^2/2 = 2 x 1/4 x 1/8 kg m/s.
    assert found.bound == near(1 / 16 / 16 + ROUNDING, rel=1e-12)
    # Too little by as much: nothing is pushed in the others, where 1/2 is due.
    still, at_rest = over_wall(law, heights=[0.75] * 5)
    assert normal_of(still, at_rest).value == near(0.5 / 16, rel=1e-14)


def test_where_a_contact_begins_the_force_is_known_to_its_change_in_an_interval():
    law = Contact(law="linear", stiffness=8.0)
    of, run = over_wall(
        law,
        heights=[1.5, 1.25, 0.75, 0.5],
        velocities=[(0, 0, 0), (0, 0, 2.0), (0, 0, 2.0), (0, 0, 2.5)],
    )
    found = normal_of(of, run)
    # Around the first interval are forces of 0, 0 and 2 N, the largest of all is 4 N.
    assert found.value == near((4.0 - 0.5) / 16, rel=1e-14)
    assert found.bound == near(4 * 0.25 * 0.5 / 16 + ROUNDING, rel=1e-12)


def test_with_a_dashpot_the_normal_impulse_may_leave_the_forces_by_a_step():
    # 8/4 + 2 x 2 = 6 N push for 1/4 s; the ball is given 2 x 2 = 4 kg m/s.
    of, run = over_wall(LINEAR, heights=[0.75] * 2, velocities=[(0, 0, -2.0), (0, 0, 0.0)])
    found = normal_of(of, run)
    assert found.value == near((4.0 - 1.5) / 16, rel=1e-14)
    # c |d''| h dt = 2 x 8 x h/4: 2 m/s in 1/4 s are more than 6 N/2 kg.
    curvature = 6 * 0.25 * (0.5**2 / 2)
    assert found.bound == near((curvature + 2 * 8 * STEP * 0.25) / 16 + ROUNDING, rel=1e-12)
    # Where the contact ends, its force may jump by c d' = 4 N within a step.
    of, run = over_wall(LINEAR, heights=[0.75, 1.25], velocities=[(0, 0, -2.0), (0, 0, 0.0)])
    ends = normal_of(of, run)
    changes = 6 * 0.25 * 0.5 + 2 * 8 * STEP * 0.25 + 4 * STEP
    assert ends.bound == near(changes / 16 + ROUNDING, rel=1e-12)


def test_friction_across_a_turning_normal_tilts_into_it():
    law = Contact(law="linear", stiffness=8.0, friction=1.0, tangential_stiffness=1.0)
    pair = instance([BALL, OTHER], (law,), times=TIMES[:2])
    turn = 0.25
    places = [[[0, 0, 0], [1.25 * np.cos(a), 1.25 * np.sin(a), 0]] for a in (-turn / 2, turn / 2)]
    # J = 2 (-1/2, 0, 1): 1 along the normal, 2 across, while k d = 2 N push for 1/4 s.
    run = standing(pair, position=places, velocity=[[[0.0] * 3] * 2, [[-0.5, 0, 1.0], [0.0] * 3]])
    found = normal_of(pair, run)
    assert found.value == near((1.0 - 0.5) / 16, rel=1e-12)
    curvature = 2 * 0.25 * (0.5**2 / 2)
    # The balls pass with v_t^2 = |v|^2 - v_n^2, and their overlap bends by v_t^2 dt^2/2|r|.
    squared = 0.5**2 + 1.0**2 - (0.5 * np.cos(turn / 2)) ** 2
    bend = squared / 1.25 * 0.25**2 / 2
    passing = 8 * bend * 0.25
    assert found.bound == near((curvature + passing + 2 * turn) / 16 + ROUNDING, rel=1e-12)


SLIDER = Contact(law="linear", stiffness=8.0, friction=0.5)


@pytest.mark.parametrize(
    ("bodies", "elements", "claims", "reason"),
    [
        ([BALL], (SLIDER, Plane()), {}, None),
        ([BALL, OTHER], (SLIDER,), {}, None),
        ([BALL, OTHER], (SLIDER, Plane()), {}, "neither two free spheres"),
        ([BALL], (SLIDER, Plane(), Plane()), {}, "neither two free spheres"),
        ([BALL, OTHER, BALL], (SLIDER,), {}, "neither two free spheres"),
        ([BALL, Body(mass=1.0)], (SLIDER,), {}, "neither two free spheres"),
        ([BALL], (Contact(law="rigid"), Plane()), {}, "contact with overlap"),
        ([BALL, OTHER], (), {}, "contact with overlap"),
        ([BALL], (SLIDER, Plane()), {"control": "exact"}, "not a fixed step"),
    ],
)
def test_it_judges_two_free_spheres_or_one_and_a_wall(bodies, elements, claims, reason):
    said = CHECK.applies(Subject(instance(bodies, elements), method(**claims), (0.1,), None))
    assert (said is None) if reason is None else (reason in said)
