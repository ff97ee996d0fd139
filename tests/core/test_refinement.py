"""Levels and bounds: where the first step lies, and how a bound falls with it."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.engine import Method
from refdem.core.refinement import (
    IMPACT_STEPS,
    bound,
    clock,
    flight,
    levels,
    past_impacts,
    round_off,
    truncation,
)
from refdem.errors import UsageError
from refdem.planning.in_process import truth_of


@pytest.fixture
def instance():
    return discovery.case("harmonic-oscillator").at()


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_first_level_has_a_bound_just_below_a_tenth_and_the_next_are_halves(instance, order):
    method = Method(name="m", summary="", control="step", order=order)
    steps = levels(instance, method, 4, 1e7)
    scales = instance.scales
    first = scales.duration / scales.tau * (steps[0] / scales.tau) ** order
    assert 0.1 / 2**order * 0.99 <= first <= 0.1 * 1.001 or steps[0] == instance.problem.interval
    assert np.allclose(np.array(steps[:-1]) / steps[1:], 2.0, rtol=0, atol=0)


def test_every_multiple_of_a_step_is_exact(instance):
    step = levels(instance, Method(name="m", summary="", control="step", order=1), 4, 1e7)[-1]
    total = 0.0
    for _ in range(1000):
        total += step
    assert total == 1000 * step
    assert np.all(instance.times / step == np.round(instance.times / step))


def test_no_level_takes_more_steps_than_allowed(instance):
    steps = levels(instance, Method(name="m", summary="", control="step", order=1), 10, 2e4)
    assert instance.times[-1] / steps[-1] <= 2e4


def test_order_with_a_feature_lowers_the_bound_only_there(instance):
    method = Method(name="m", summary="", control="step", order=4, order_with={"spring": 1})
    t = instance.times
    assert truncation(instance, method, 0.01, t)[-1] == pytest.approx((1 + t[-1]) * 0.01)
    plain = Method(name="m", summary="", control="step", order=4, order_with={"contact": 1})
    assert truncation(instance, plain, 0.01, t)[-1] == pytest.approx((1 + t[-1]) * 1e-8)


def test_round_off_follows_the_declared_precision(instance):
    double = Method(name="m", summary="", control="exact")
    single = Method(name="m", summary="", control="exact", precision="single")
    assert round_off(instance, single, 100) / round_off(instance, double, 100) == 2.0**29


def test_a_motion_too_long_for_the_first_level_starts_at_what_is_affordable():
    long = discovery.case("harmonic-oscillator").at(duration="1e5")
    method = Method(name="m", summary="", control="step", order=2)
    steps = levels(long, method, 4, 1e6)
    assert 4.99e5 < long.times[-1] / steps[0] <= 1e6
    assert levels(long, method, 4, 5e4) == ()


def test_a_first_step_that_no_run_could_finish_is_refused(instance):
    with pytest.raises(UsageError, match="expected at most 1e"):
        levels(instance, Method(name="m", summary="", control="step", order=2), 4, 1e6, 1e-300)


def test_a_clock_that_is_summed_may_be_off_by_a_rounding_a_step(instance):
    exact, summed = (
        Method(name="m", summary="", control="exact", summed_clock=flag) for flag in (False, True)
    )
    assert clock(instance, exact, 0.0) == 0.0
    losses = np.cumsum(np.full(64 + 80, 20.0 * 2.0**-53))
    assert 0.9 * losses[-1] < clock(instance, summed, 0.0) < 1.1 * losses[-1]


def test_a_summed_clock_of_given_steps_counts_where_a_drive_reads_it(instance):
    stepped = Method(name="m", summary="", control="step", order=2, summed_clock=True)
    assert clock(instance, stepped, 2.0**-8) == 0.0
    driven = discovery.case("driven-oscillator").at()
    turns = driven.scales.duration / driven.scales.tau
    assert clock(driven, stepped, 2.0**-8) == pytest.approx(
        2.0**-53 * turns * driven.times[-1] * 2**8
    )


def test_an_order_is_read_from_finer_levels_where_there_are_kinks_and_from_none_without_levels():
    from refdem.core.refinement import order_levels

    smooth, rubbing = (
        discovery.case(name).at() for name in ("harmonic-oscillator", "coulomb-oscillator")
    )
    second = Method(name="second", summary="", control="step", order=2)
    fourth = Method(name="fourth", summary="", control="step", order=4)
    finer = (0.5, 0.25, 0.125, 0.0625)
    assert order_levels(smooth, second, (0.5, 0.25)) == (0.5, 0.25)
    assert order_levels(rubbing, second, (0.5, 0.25)) == finer
    assert order_levels(rubbing, second, ()) == ()
    # The second derivative of |v| v jumps: it limits the fourth order, and not the second.
    falling = discovery.case("quadratic-drag").at()
    assert order_levels(falling, second, (0.5, 0.25)) == (0.5, 0.25)
    assert order_levels(falling, fourth, (0.5, 0.25)) == finer


def test_roundings_of_equal_terms_add_up_step_by_step():
    from refdem.core.refinement import flight

    step, exact = (
        Method(name="m", summary="", control=control, order=2, precision="single")
        for control in ("step", "exact")
    )
    spheres, swings = (discovery.case(name).at() for name in ("two-spheres", "harmonic-oscillator"))
    h = float(spheres.times[1]) / 1024
    assert flight(swings, step, h) == flight(spheres, exact, h) == 0.0
    claimed = flight(spheres, step, h)
    place = np.float32(1.0)
    moved = np.float32(1.0) + np.float32(0.3)
    term = np.float32(0.3 / 65536)
    steps = 65536
    for _ in range(steps):
        place += term
    drift = abs(float(place) - float(moved))
    random = 8 * 2.0**-24 * np.sqrt(steps)
    assert drift > random  # of equal terms: more than roundings of random sign would leave
    assert drift < 2.0**-24 * steps
    assert claimed == pytest.approx(2.0**-24 * spheres.times[-1] / h)


def rubbed(real, steps):
    """Where velocity Verlet, which subtracts dry friction from the velocity by itself, leaves an
    oscillator after 16 s.
    """
    h = real(16) / real(steps)
    rub = real(0.06) * h / real(2)
    pull = h / real(2) * real(1.5)
    x = real(-0.75)
    v = real(0.5)
    for _ in range(steps):
        for half in (0, 1):
            v = v - pull * x
            if abs(v) <= rub:
                v = real(0)
            else:
                v = v - np.copysign(rub, v)
            if half:
                x = x
            else:
                x = x + h * v
    return np.array([x, v], float)


def test_dry_friction_of_constant_size_rounds_alike_step_by_step():
    from refdem.core.refinement import flight, round_off

    step = Method(name="m", summary="", control="step", order=2, precision="single")
    instance = discovery.case("coulomb-oscillator").at(duration="16", samples="16")
    steps = 16384
    strayed = float(np.abs(rubbed(np.float32, steps) - rubbed(np.float64, steps)).max())
    claimed = flight(instance, step, 16 / steps)
    assert claimed == pytest.approx(2.0**-24 * steps)
    assert strayed > 2 * round_off(
        instance, step, steps
    )  # more than roundings of random sign would leave
    assert strayed < claimed


def spun(steps):
    """Length of an angular velocity that single precision turns about the three axes of a sphere,
    as a symmetric splitting does.
    """
    w = np.array([0.3, 0.5, 0.7], np.float32)
    h = np.float32(20.0 / steps)
    for _ in range(steps):
        for axis, part in ((2, 0.5), (1, 0.5), (0, 1.0), (1, 0.5), (2, 0.5)):
            j = (axis + 1) % 3
            k = (axis + 2) % 3
            angle = np.float32(part) * h * w[axis]
            c = np.cos(angle)
            s = np.sin(angle)
            turned = c * w[j] + s * w[k], c * w[k] - s * w[j]
            w[j], w[k] = turned
    return float(np.linalg.norm(w.astype(float)))


def test_turns_by_equal_angles_stretch_alike_step_by_step():
    from refdem.core.refinement import round_off, turning

    step = Method(name="m", summary="", control="step", order=2, precision="single")
    sphere, swings = (
        discovery.case(name).at(duration="20", samples="16")
        for name in ("free-rigid-body", "harmonic-oscillator")
    )
    steps = 4096
    start = float(np.linalg.norm(np.array([0.3, 0.5, 0.7], np.float32).astype(float)))
    strayed = abs(spun(steps) / start - 1.0)
    claimed = turning(sphere, step, 20 / steps)
    assert turning(swings, step, 20 / steps) == 0.0
    assert round_off(sphere, step, steps) / 2 < strayed < claimed / 3


@pytest.mark.parametrize(
    ("case", "adds"),
    [("quadratic-drag", True), ("hard-wall", True), ("harmonic-oscillator", False)],
)
def test_a_body_that_drag_holds_at_its_last_speed_adds_the_same_at_every_step(case, adds):
    instance = discovery.case(case).at()
    second = Method(name="second", summary="", control="step", order=2)
    assert (flight(instance, second, 2.0**-10) > 0) == adds


PAIRS = [
    ("hard-spheres", {}),
    ("hard-spheres", {"offset": "1/2,0", "masses": "1,5", "radii": "1/2,1"}),
    ("billiard-break", {"rows": "2", "restitution": "3/4"}),
    ("hard-wall", {}),
]


@pytest.mark.parametrize(("case", "given"), PAIRS)
def test_levels_go_on_until_the_motion_after_its_impacts_can_be_judged(case, given):
    """The bound at the end, S of the impacts in it, is an eightieth at the coarsest level."""
    motion = discovery.case(case).at(**given)
    truth = truth_of(motion)
    first_order = Method(name="m", summary="", control="step", order=1)
    before = levels(motion, first_order, 4, 3e5)
    assert bound(motion, first_order, before[0], truth)[-1] > 0.1
    after = past_impacts(motion, first_order, before, truth, 3e5)
    assert len(after) == len(before)
    assert motion.times[-1] / after[-1] <= IMPACT_STEPS
    reached = bound(motion, first_order, after[0], truth)[-1]
    as_fine_as_allowed = motion.times[-1] / after[-1] > IMPACT_STEPS / 2
    assert reached <= 0.1 / 8 or as_fine_as_allowed
    assert bound(motion, first_order, after[-1], truth)[-1] < 0.01


def test_levels_stay_where_nothing_meets_or_a_method_sees_impacts_as_they_happen():
    motion = discovery.case("hard-spheres").at()
    truth = truth_of(motion)
    given = {"name": "m", "summary": "", "control": "step", "order": 1}
    before = levels(motion, Method(**given), 4, 3e5)
    for claims in ({"locates_events": True}, {"velocity_time": "minus-half-step"}):
        assert past_impacts(motion, Method(**given, **claims), before, truth, 3e5) == before
    coarse = past_impacts(motion, Method(**given), before, truth, 2 * motion.times[-1] / before[-1])
    assert coarse == tuple(level / 2 for level in before)
    rolling = discovery.case("rolling").at()
    of_rolling = levels(rolling, Method(**given), 4, 3e5)
    assert past_impacts(rolling, Method(**given), of_rolling, truth_of(rolling), 3e5) == of_rolling
