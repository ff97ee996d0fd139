"""Observed orders, what halvings of a step and ways back predict, and the limits between verdicts,
with errors that are made by hand.

SCALES: L = 4 m, tau = 1/2 s, T = 8 s. Errors are those of x, whose scale is 4 m.
"""

from math import inf, log2, sqrt

import numpy as np
import pytest

from refdem.checks import _kinks, convergence, error, order, reversal
from refdem.checks.order import (
    CHECK,
    Misfits,
    _order_at_most,
    _rounding,
    expected_deficit,
    mean_order,
    order_deficit,
)
from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.judgement import Sight
from refdem.core.quantity import Quantity
from refdem.core.trajectory import Cost
from refdem.core.variant import Variant
from refdem.scene import Body, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from tests.handmade import U, findings, instance, method, near, standing, truth

TIMES = (0.0, 2.0, 4.0, 6.0, 8.0)
POINT = Body(mass=2.0)
BALL = Body(mass=2.0, inertia=(0.8,) * 3, shape=Sphere(radius=1.0), position=(0, 0, 3.0))
SPRING = Spring(a=0, b=-1, stiffness=3.0)
SOFT = Contact(law="linear", stiffness=8.0)
RUBBING = Slider(a=0, friction=0.5, normal_force=1.0)
H = 2.0**-6
LEVELS = (4 * H, 2 * H, H)
ROUND_OFF = 8 * U * sqrt(8 / H)
LIKE = {"rel": 1e-9}


def swinging(elements=(SPRING,), bodies=(POINT,), quantities=None):
    """An instance that observes x in units of 4 m."""
    return instance(list(bodies), elements, times=TIMES, quantities=quantities or {"x": 4.0})


def known_of(growth=None, **more):
    """Truth that says x = 0 at all samples."""
    return truth(TIMES, {"x": [0.0] * 5}, growth=growth, **more)


def wrong_by(of, errors):
    """Runs by variant, whose x is off by these errors (5,) by level, in units of its scale."""

    def run(variant):
        offs = np.broadcast_to(errors[variant.level], 5)
        return standing(of, position=[[[4 * off, 0, 0]] for off in offs])

    return run


def judged(name, errors, *, of=None, known="certified", claims=None, levels=LEVELS):
    """Findings of a check on runs that are off by errors."""
    of = of or swinging()
    samples = known_of() if known == "certified" else known
    subject = Subject(of, claims or method(), levels, samples)
    return findings(discovery.check(name), subject, wrong_by(of, errors))


# Deficits


@pytest.mark.parametrize(
    ("orders", "deficit"),
    [
        ([2.5], 0.0),
        ([1.5], 0.5),
        ([1.25, 1.75], 0.0),
        ([1.5, 1.75], 0.0),
        ([1.625, 1.75], 0.125),
        ([1.875, 1.75], 0.25),
        ([0.5, 1.5], 0.5),
        ([0.5, 1.625], 0.0),
        ([1.0, 1.75, 1.75], 0.25),
    ],
)
def test_a_deficit_that_halves_is_none_and_one_of_half_an_order_is_not_excused(orders, deficit):
    assert order_deficit(orders, 2.0) == deficit


@pytest.mark.parametrize(
    ("orders", "expected"),
    [
        ([1.0, 2.0], inf),
        ([1.0, 1.875, 2.0], 0.5),
        ([3.0, 2.25, 2.0], 0.5),
        ([1.75, 1.5, 2.0], 0.5),
        ([9.0, 1.75, 1.875, 0.0], 0.125),
    ],
)
def test_a_deficit_is_expected_to_be_the_one_before_or_half_of_the_one_before_that(
    orders, expected
):
    assert expected_deficit(orders, 2.0) == expected


def test_a_mean_order_is_a_slope_of_least_squares_with_two_deviations():
    slope, by_kinks, shown = mean_order([4.0, 2.0, 1.0], [16.0, 4.0, 1.0])
    assert (slope, shown) == (near(2.0), pytest.approx(0.0, abs=1e-14))
    assert by_kinks == near(1 / sqrt(2.0))
    # log2 of errors 1, 3, 2, 6 at 0, 1, 2, 3: x y = 8, x x = 5; residuals -1/5, 2/5, -11/5, 1/5 ...
    slope, by_kinks, shown = mean_order([1.0, 2.0, 4.0, 8.0], [2.0, 8.0, 4.0, 64.0])
    y = np.array([1.0, 3.0, 2.0, 6.0]) - 3.0
    x = np.array([-1.5, -0.5, 0.5, 1.5])
    assert slope == near(7 / 5)
    assert by_kinks == near(1 / sqrt(5.0))
    assert shown == near(sqrt(float(np.sum((y - 1.4 * x) ** 2)) / 2 / 5))
    assert mean_order([2.0, 1.0], [2.0, 1.0])[2] == inf


def test_a_fit_with_two_powers_of_the_step_leaves_what_is_of_another_one():
    h = np.array([4.0, 2.0, 1.0])[:, None]
    a = np.array([1.0, -3.0])
    b = np.array([-0.5, 2.0])
    exact = a * h**2 + b * h**3
    assert order._fit_residual(list(exact), 2, 3) == pytest.approx(0.0, abs=1e-14)
    # Of a linear error c h alone (x + y) 2 - x y 4 = 5/8 + ... : 1 - (3/8 2 - 1/32 4) = 3/8.
    assert order._fit_residual(list(a * h), 2, 3) == near(3 / 8, rel=1e-13)
    assert order._fit_residual(list(exact), 1, 2) > 0.1


def subject_of(claims=None, of=None, **more):
    """A subject with certified truth."""
    return Subject(of or swinging(), claims or method(), LEVELS, known_of(**more))


@pytest.mark.parametrize(
    ("orders", "expected", "misfits", "outcome", "value", "bound"),
    [
        ([1.85], inf, None, "pass", 0.15, 0.15),
        ([1.84], inf, None, "undecided", None, None),
        ([1.11], inf, None, "undecided", None, None),
        ([1.09], inf, None, "fail", 0.91, 0.15),
        ([1.7, 1.7], inf, None, "fail", 0.3, 0.15),
        ([1.7, 1.7], inf, Misfits(0.2, 0.1), "fail", 0.3, 0.15),
        ([1.7, 1.7], inf, Misfits(0.1, 0.2), "pass", 0.1, 0.1),
        ([1.7, 1.7], inf, Misfits(0.1, 0.1), "pass", 0.1, 0.1),
        ([1.7, 1.7], inf, Misfits(0.101, 0.2), "undecided", None, None),
        ([1.9, 1.9], 0.125, None, "pass", 0.1, 0.125),
        ([1.9, 1.9], 0.05, None, "pass", 0.1, 0.15),
        ([1.9, 1.9], 0.05, Misfits(0.2, 0.1), "fail", 0.1, 0.05),
        ([1.9, 1.9], 0.05, Misfits(0.1, 0.2), "pass", 0.1, 0.15),
        ([1.8, 1.9], 0.05, Misfits(0.2, 0.1), "fail", 0.1, 0.05),
    ],
)
def test_the_deficit_of_pairs_meets_its_tolerance(orders, expected, misfits, outcome, value, bound):
    found = CHECK._deficit(subject_of(), orders, expected, misfits)
    assert found.outcome == outcome, found.sentence
    if value is not None:
        assert (found.value, found.bound) == (near(value), near(bound))


@pytest.mark.parametrize(
    ("order", "next_order", "outcome"),
    [
        # The claimed order is 2, the tolerance 0.15, and a whole order less 0.1 is much for a pair.
        # The next pair may lack half as much.
        (1.0, 1.4, "fail"),
        (1.0, 1.6, "undecided"),
        (1.0, inf, "undecided"),
        (1.2, 1.0, "undecided"),
        (1.9, 1.0, "pass"),
    ],
)
def test_one_pair_speaks_against_a_claim_only_if_the_next_does_not_lack_less(
    order, next_order, outcome
):
    found = CHECK._deficit(subject_of(), [order], inf, None, next_order)
    assert found.outcome == outcome, found.sentence


def test_the_next_order_is_that_of_an_error_less_its_rounding():
    subject = subject_of()
    levels = (4 * H, 2 * H, H)
    rounding = _rounding(subject, H)
    floor = [20 * _rounding(subject, h) for h in levels]
    largest = [1.0, 32 * rounding, 9 * rounding]
    assert _order_at_most(subject, levels, largest, floor) == near(2.0)
    assert _order_at_most(subject, levels, [1.0, 32 * rounding, rounding], floor) == inf
    assert _order_at_most(subject, levels, [1.0, 0.5, 0.25], floor) == -inf


def test_the_tolerance_of_high_orders_is_a_twentieth_of_them():
    found = CHECK._deficit(subject_of(method(order=8)), [7.7, 7.7], inf, None)
    assert (found.value, found.bound) == (near(0.3), near(0.4))


def test_an_order_is_seen_at_the_finest_pair_of_three_levels():
    found = judged("order", {4 * H: 0.02, 2 * H: 0.0052, H: 0.00135})["state"]
    assert found.order_seen == near(log2(0.0052 / 0.00135))
    assert (found.outcome, found.order_claimed) == ("pass", 2.0)
    missing = judged("order", {4 * H: 0.02, 2 * H: 0.01, H: 0.005})["state"]
    assert (missing.outcome, missing.value) == ("fail", near(1.0))


def test_errors_within_twenty_roundings_show_no_order():
    floor = 20 * ROUND_OFF
    found = judged("order", {4 * H: 0.01, 2 * H: 0.9 * 20 * 8 * U * 16, H: 0.9 * floor})
    state = found["state"]
    assert state.outcome == "pass"
    assert "every level but the coarsest" in state.sentence
    assert state.value == near(0.9 * floor)
    assert state.bound == near(floor)
    everywhere = judged("order", dict.fromkeys(LEVELS, 0.5 * 20 * 8 * U * 16))["state"]
    assert "The error at every level is" in everywhere.sentence
    assert set(found) == {"state"}


def test_levels_count_between_twenty_roundings_and_a_tenth_of_the_scale():
    # The bound at the end is 17 (2 h)^2 + noise; times the growth.
    levels = tuple(2.0**-k for k in range(3, 9))
    subject = Subject(swinging(), method(), levels, known_of())
    counting, common = order._counting_levels(subject, levels)
    # 17/4^k falls below a tenth from 2 h = 1/16 on; at 2 h = 1/8 it is 0.27, at 1/4 1.06.
    assert (counting, common) == ([2.0**-5, 2.0**-6, 2.0**-7, 2.0**-8], 5)
    finer = (*levels, 2.0**-9)
    rough = Subject(swinging(), method(precision="single"), finer, known_of())
    # 20 x 8 u sqrt(n) with u = 2^-24 is 6e-4 at 2^-9, where the truncation is 17/4^8 = 2.6e-4.
    assert order._counting_levels(rough, finer) == (counting, 5)


def test_levels_are_compared_on_the_samples_of_the_third_finest():
    grown = known_of(growth=[1.0, 1.0, 1.0, 1.0, 64.0])
    subject = Subject(swinging(), method(), (2.0**-5, 2.0**-6, 2.0**-7, 2.0**-8), grown)
    # At the last sample 64 x 17 (2 h)^2 is below a tenth at 2^-8 alone: 0.066; at 2^-7 0.27.
    counting, common = order._counting_levels(subject, subject.levels)
    assert (counting, common) == ([2.0**-5, 2.0**-6, 2.0**-7, 2.0**-8], 4)


@pytest.mark.parametrize(
    ("sizes", "value"),
    [
        ((1e-3, 1.2e-3, 1.44e-3), log2(1.44)),
        # Octaves of 0.25 are no growth: 2^(1/4) = 1.189.
        ((1e-3, 1.18e-3, 1.8e-3), 0.0),
        ((1e-3, 1.5e-3, 1.7e-3), 0.0),
        ((1e-3, 0.9e-3, 2e-3), 0.0),
    ],
)
def test_errors_grow_that_rise_by_a_quarter_of_an_octave_at_every_halving(sizes, value):
    found = judged("order", dict(zip(LEVELS, sizes, strict=True)))["growth"]
    assert (found.value, found.bound) == (near(value), 0.0)


def test_errors_are_compared_while_they_are_small():
    offs = {
        h: [0.0, size, 0.26 * (h == H), size, size]
        for h, size in zip(LEVELS, (1e-3, 2e-3, 4e-3), strict=True)
    }
    found = judged("order", offs)["growth"]
    assert found.value == near(2.0)
    none = {
        h: [0.0, 0.26, size, size, size] for h, size in zip(LEVELS, (1e-3, 2e-3, 4e-3), strict=True)
    }
    # Only the first sample is common to all, and there nothing is off.
    assert "growth" not in judged("order", none)


@pytest.mark.parametrize(
    ("slope", "outcome"), [(1.51, "pass"), (1.49, "undecided"), (0.9, "undecided"), (0.88, "fail")]
)
def test_where_kinks_scatter_errors_the_mean_order_counts_beyond_its_deviation(slope, outcome):
    # Five levels, an octave apart, have a spread of 10: 3.5 deviations of 1/sqrt(10) are 1.107.
    of = swinging((SPRING, RUBBING))
    coarser = (H, H / 2, H / 4)
    levels = (*coarser, H / 8, H / 16)
    scatter = np.array([0.6, -0.6, 0.9, -0.9, 0.0])
    octaves = np.array([4.0, 3.0, 2.0, 1.0, 0.0])
    tilt, _, _ = mean_order(list(2.0**octaves), list(2.0**scatter))
    sizes = 1e-5 * 2.0 ** (scatter + (slope - tilt) * octaves)
    errors = dict(zip(levels, sizes, strict=True))
    found = judged("order", errors, of=of, levels=coarser)["state"]
    assert found.outcome == outcome, found.sentence
    if found.value is not None:
        assert found.order_seen == near(slope, rel=1e-6)
        assert found.bound == 0.5
        assert found.value == near(max(0.0, 2 - slope), rel=1e-6)


def test_a_force_that_allows_the_claimed_order_limits_nothing():
    # |s|^(3/2) allows order 5/2: a claim of 2 stands, and one of 3 hears what to declare.
    hertz = (Contact(law="hertz", stiffness=8.0), Plane())
    of = instance([BALL], hertz, times=TIMES, quantities={"x": 4.0})
    errors = {h: 1e-5 * (h / H) ** 2.4 for h in (*LEVELS, H / 2, H / 4)}
    modest = judged("order", errors, of=of, claims=method(order=2))["state"]
    assert "order 2 is claimed; kinks" in modest.sentence
    bold = judged("order", errors, of=of, claims=method(order=3))["state"]
    assert "a force that varies as |s|^1.5 limits fixed steps to order 2.5" in bold.sentence


# Error against truth


def test_the_bound_at_the_finest_level_is_that_of_the_last_halvings_where_it_is_smaller():
    errors = {4 * H: 4e-4, 2 * H: 1.1e-4, H: 3e-5}
    found = judged("error", errors)["x"]
    # The change from 2 h to h is 8e-5, that from 4 h is 2.9e-4, a fourth of it 7.25e-5; times 4/3.
    finest = 8e-5 * 4 / 3 + 20 * ROUND_OFF
    assert found.value == near(3e-5, **LIKE)
    assert found.bound == near(finest, **LIKE)
    earlier = judged("error", {4 * H: 8e-4, 2 * H: 1.1e-4, H: 3e-5})["x"]
    assert earlier.bound == near(6.9e-4 / 4 * 4 / 3 + 20 * ROUND_OFF, **LIKE)
    exact = judged("error", dict.fromkeys((0.0,), 1e-16), claims=method("exact"), levels=(0.0,))[
        "x"
    ]
    assert exact.bound == near(8 * U * 16, rel=1e-14)


def estimate(errors, of=None, claims=None, levels=LEVELS, growth=None, sample=-1):
    """The bound at the finest level that the runs show for each other."""
    of = of or swinging()
    subject = Subject(of, claims or method(), levels, known_of(growth=growth))
    run = wrong_by(of, errors)
    runs = {Variant(h): CompletedRun(run(Variant(h)), Cost(seconds=0.0)) for h in levels}
    found = error._error_from_halvings(subject, runs)
    return found if found is None else float(found["x"][sample])


def test_halvings_that_do_not_show_the_order_yet_imply_what_they_show():
    # Changes of 2e-4 and 1e-4 fall by 2, in place of 16 of order 4: the rest is 1 of the last one.
    slow = estimate({4 * H: 4e-4, 2 * H: 2e-4, H: 1e-4}, claims=method(order=4))
    assert slow == near(4 * 1e-4 + 20 * ROUND_OFF, **LIKE)
    # By more than half of 4: the claim stands, 1/3 of it.
    claimed = estimate({4 * H: 4.1e-4, 2 * H: 2e-4, H: 1e-4}, claims=method(order=2))
    assert claimed == near(4 / 3 * 1e-4 + 20 * ROUND_OFF, **LIKE)
    # They do not fall at all.
    assert estimate({4 * H: 2e-4, 2 * H: 2e-4, H: 1e-4}, claims=method(order=4)) is None


def test_where_kinks_scatter_errors_the_room_is_64_or_16_and_a_straddled_step_is_added():
    errors = {4 * H: 4e-4, 2 * H: 1.1e-4, H: 3e-5}
    change = 8e-5
    slides = swinging((SPRING, RUBBING))
    noise = ROUND_OFF + U * 8 / H
    # A jump: 64 times the change. x does not move, so that no straddled step is off.
    assert estimate(errors, slides) == near(64 * change + 20 * noise, **LIKE)
    located = method(locates_events=True)
    assert estimate(errors, slides, located) == near(16 * change + 20 * noise, **LIKE)
    # An order that only steps can have that end at every kink.
    cuts = method(order=3, locates_events=True)
    assert estimate(errors, slides, cuts) == near(16 / 7 * change + 20 * noise, **LIKE)
    # The same where the method says so, whatever its order.
    said = method(locates_events=True, cuts_steps=True)
    assert estimate(errors, slides, said) == near(16 / 3 * change + 20 * noise, **LIKE)
    # |s|^(3/2) leaves h^(5/2), above order 2: 16/(2^2 - 1), and order 3 comes to 5/2 itself.
    hertz = instance(
        [BALL], (Contact(law="hertz", stiffness=8.0), Plane()), times=TIMES, quantities={"x": 4.0}
    )
    assert estimate(errors, hertz) == near(16 / 3 * change + 20 * noise, **LIKE)
    assert estimate(errors, hertz, method(order=3)) == near(64 * change + 20 * noise, **LIKE)


def test_a_step_that_straddles_a_kink_is_off_by_the_rate_times_the_step():
    slides = swinging((SPRING, RUBBING))
    offs = [0.0, 0.0, 0.25, 0.0, 0.0]
    errors = dict.fromkeys(LEVELS, offs)
    # x moves by a quarter of its scale in 2 s; friction jumps: 4 x rate x h.
    noise = ROUND_OFF + U * 8 / H
    expected = 4 * (0.25 / 2) * H + 20 * noise
    assert estimate(errors, slides) == near(expected, **LIKE)
    assert estimate(errors, slides, sample=0) == near(20 * noise, **LIKE)
    assert estimate(errors, slides, sample=1) == near(expected, **LIKE)
    # A linear contact has a kink: a force of at most h/tau = 1/32 of what it comes to.
    touching = instance([BALL], (SOFT, Plane()), times=TIMES, quantities={"x": 4.0})
    expected = 4 / 32 * (0.25 / 2) * H + 20 * noise
    assert estimate(errors, touching) == near(expected, **LIKE)


def test_errors_of_tolerances_fall_with_them_and_the_whole_run_counts():
    levels = (1e-6, 1e-8, 1e-10)
    errors = {1e-6: [0, 1e-4, 0, 0, 0], 1e-8: [0.0] * 5, 1e-10: [0, 0, 3e-7, 0, 0]}
    found = estimate(errors, claims=method("tolerance"), levels=levels, sample=0)
    # A hundredth of the change before is 1e-6: more than 3e-7.
    assert found == near(4 * 1e-6 + 20 * 8 * U * 16, rel=1e-9)
    # A tolerance whose bound is above a tenth of the scale says nothing; a step says it still.
    loose = (1e-3, 1e-5, 1e-7)
    by_level = dict(zip(loose, errors.values(), strict=True))
    assert estimate(by_level, claims=method("tolerance"), levels=loose) is None
    coarse = (0.25, 0.125, 0.0625)
    assert estimate(dict(zip(coarse, errors.values(), strict=True)), levels=coarse) is not None
    still = {h: [0.0] * 5 for h in levels}
    assert estimate(still, claims=method("tolerance"), levels=levels) is None


def test_the_growth_of_errors_grows_round_off_of_an_estimate():
    errors = dict.fromkeys(LEVELS, 0.0)
    found = estimate(errors, growth=[1, 1, 1, 2, 5.0])
    assert found == near(5 * 20 * ROUND_OFF, rel=1e-13)
    assert estimate({LEVELS[0]: 0.0, LEVELS[1]: 0.0}, levels=LEVELS[:2]) is None


def test_an_estimate_counts_up_to_ten_scales():
    allowed = np.array([1.0, 10.0, 10.1, 1.0])
    found = error._smaller_bound(allowed, np.array([0.5, 0.5, 0.5, 0.5]))
    assert found.tolist() == [0.5, 0.5, 10.1, 1.0]
    short = error._smaller_bound(allowed[:2], np.array([0.5]))
    assert short.tolist() == [0.5, 10.0]
    assert error._smaller_bound(allowed, None) is allowed


def test_the_level_nearest_to_its_bound_decides_among_those_that_see():
    sharp = Sight(0.01, 1.0)
    blind = Sight(0.5, 1.0)
    errors = {
        1.0: np.array([0.4, 9.0]),
        0.5: np.array([0.005, 0.002]),
        0.25: np.array([0.001, 0.0]),
    }
    bounds = {1.0: np.array([0.5]), 0.5: np.array([0.01, 0.01]), 0.25: np.array([0.01, 0.01])}
    sights = {1.0: blind, 0.5: sharp, 0.25: sharp}
    assert error._decisive_level(errors, bounds, sights) == 0.5
    beyond = errors | {1.0: np.array([0.51, 0.0])}
    assert error._decisive_level(beyond, bounds, sights) == 1.0
    broken = errors | {0.25: np.array([np.nan, 0.0])}
    assert error._decisive_level(broken, bounds, sights) == 0.25
    assert error._decisive_level(errors, bounds, dict.fromkeys(sights, blind)) == 1.0


def test_levels_are_told_with_their_bound_order_and_constant():
    errors = {4 * H: 0.004, 2 * H: 0.0012, H: 0.0003}
    found = judged("error", errors)["x"]
    listed = {level.level: level for level in found.levels}
    for h in LEVELS:
        assert listed[h].error == near(errors[h], **LIKE)
        noise = 8 * U * max(16, sqrt(8 / h))
        assert listed[h].bound == near(17 * (2 * h) ** 2 + noise, **LIKE)
    # 17/64 is above a tenth of the scale.
    assert [listed[h].counts for h in LEVELS] == [False, True, True]
    assert found.order_seen == near(2.0, **LIKE)
    assert found.constant_seen == near(0.0012 / (17 * (4 * H) ** 2), **LIKE)
    claims = method(constant=0.5)
    halved = judged("error", {h: e / 4 for h, e in errors.items()}, claims=claims)["x"]
    assert halved.constant_seen == near(
        max(0.001 / (17 * (8 * H) ** 2), 0.0003 / (17 * (4 * H) ** 2)), **LIKE
    )


def test_a_level_counts_whose_bound_at_the_end_is_twenty_roundings():
    # In single precision 20 x 8 u sqrt(8/h) is 4.3e-4 and 6.1e-4; 17 (2 h)^2 is 1e-3 and 2.6e-4,
    # and 17 times less at the start.
    claims = method(precision="single")
    levels = (2.0**-8, 2.0**-9)
    found = judged("error", dict.fromkeys(levels, 1e-5), claims=claims, levels=levels)["x"]
    assert [level.counts for level in found.levels] == [True, False]


def test_a_quantity_that_truth_moves_within_round_off_has_no_signal():
    of = swinging()
    for way, moves in ((0.9, False), (1.1, True)):
        known = truth(TIMES, {"x": [0, way * 4 * ROUND_OFF, 0, 0, 0]})
        signals = error._signals(Subject(of, method(), LEVELS, known), known)
        assert bool(signals["x"].any()) == moves


def test_changes_of_angles_are_those_modulo_a_turn():
    theta = Quantity("theta", "rad", 0.5, angle=True)
    of = instance([POINT], (SPRING,), times=TIMES, quantities=[theta, Quantity("x", "m", 4.0)])
    coarse = {"theta": np.array([3.0, 1.0]), "x": np.array([0.0, 2.0])}
    fine = {"theta": np.array([-3.0, 1.0]), "x": np.array([0.0, 0.0])}
    found = error._changes(of, coarse, fine, 2)
    np.testing.assert_allclose(found["theta"], [2 * (2 * np.pi - 6.0), 0.0], rtol=1e-13)
    np.testing.assert_allclose(found["x"], [0.0, 0.5], rtol=1e-13)


def left_beside(of, xs, ys=(0.0,) * 5):
    """What straddled steps of 1/8 s leave in every quantity of a run with these x and y [m]."""
    run = standing(of, position=[[[x, y, 3.0]] for x, y in zip(xs, ys, strict=True)])
    return _kinks.straddled(Subject(of, method(), LEVELS, None), 1 / 8, run, 5)


def test_a_straddled_step_leaves_the_rate_so_far_of_its_quantity_and_a_tenth_of_others():
    theta = Quantity("vz", "rad", 0.5, angle=True)
    places = [Quantity(name, "m", 4.0) for name in "xy"]
    touching = instance([BALL], (SOFT, Plane()), times=TIMES, quantities=[theta, *places])
    found = left_beside(touching, (0, 0, 0, 2.0, 2.0), (0, 0.01, 0.01, 0.01, 0.01))
    # 4 (h/tau) h |dq/dt| with h = 1/8 s and tau = 1/2 s: x moves by 1/2 of its scale in 2 s.
    each = 4 * (1 / 4) * (1 / 8)
    assert found["x"].tolist() == near([each * 0.000125] * 2 + [each / 4] * 3)
    assert found["y"].tolist() == near([each * 0.00125] * 2 + [each / 40] * 3)
    # The rate of an angle is that of the fastest.
    assert found["vz"].tolist() == near([each * 0.00125] * 2 + [each / 4] * 3)


def test_a_scene_of_angles_alone_shows_no_rate():
    theta = Quantity("vz", "rad", 0.5, angle=True)
    turning = instance([BALL], (SOFT, Plane()), times=TIMES, quantities=[theta])
    assert left_beside(turning, (0, 1.0, 2.0, 3.0, 4.0))["vz"].tolist() == [0.0] * 5


def test_friction_jumps_where_the_slip_may_change_its_sign_and_not_where_it_lasts():
    law = Contact(law="linear", stiffness=8.0, friction=0.125)
    rubbing = instance([BALL], (law, Plane()), times=TIMES, quantities={"x": 4.0})
    subject = Subject(rubbing, method(), LEVELS, None)
    pressed = [[[0, 0, 0.75]]] * 5
    for speeds, expected in (((8.0, 7.5, 7.0, 6.5, 6.0), 1.0), ((1.0, 0.5, 0.0, 0.0, 0.0), 0.0)):
        run = standing(rubbing, position=pressed, velocity=[[[v, 0, 0]] for v in speeds])
        assert _kinks.sharpest_kink(subject, H, run) == expected
    # A dashpot jumps at the touch, whatever the slip does.
    damped = Contact(law="linear", stiffness=8.0, friction=0.125, damping=1.0)
    jumping = Subject(
        instance([BALL], (damped, Plane()), times=TIMES, quantities={"x": 4.0}),
        method(),
        LEVELS,
        None,
    )
    sliding = standing(rubbing, position=pressed, velocity=[[[8.0, 0, 0]]] * 5)
    assert _kinks.sharpest_kink(jumping, H, sliding) == 0.0


# Self-convergence


def converged(errors, of=None, claims=None, apart=0.0, levels=LEVELS):
    """The finding of self-convergence; the perturbed start ends `apart` from the plain one."""
    of = of or swinging()
    subject = Subject(of, claims or method(), levels, None)
    plain = wrong_by(of, errors)

    def run(variant):
        made = plain(variant)
        if variant.change == "perturbed":
            return standing(of, position=made.position + 4 * apart)
        return made

    return findings(convergence.CHECK, subject, run)["state"]


def test_changes_of_a_run_fall_with_the_order_within_twice_the_tolerance():
    found = converged({4 * H: 0.0, 2 * H: 1e-3, H: 1e-3 + 1.2e-3 / 4})
    assert found.order_seen == near(log2(4 / 1.2), **LIKE)
    assert found.value == near(2 - log2(4 / 1.2), **LIKE)
    assert found.bound == near(0.3)
    steep = converged({4 * H: 0.0, 2 * H: 1e-3, H: 1e-3 + 1e-5}, claims=method(order=8))
    assert steep.bound == near(0.8)


def test_changes_within_twenty_roundings_of_the_growth_are_of_the_claimed_order():
    # Neighbours are 2^-40 apart: 64 times the perturbation 2^-46, and eight times that may grow.
    growth = 8 * 2.0**-40 / 2.0**-46
    floor = 20 * ROUND_OFF * growth
    within = converged({4 * H: 0.0, 2 * H: 1e-10, H: 1e-10 + 0.99 * floor}, apart=2.0**-40)
    assert (within.value, within.order_seen) == (0.0, 2.0)
    beyond = converged({4 * H: 0.0, 2 * H: 1e-10, H: 1e-10 + 1.01 * floor}, apart=2.0**-40)
    assert beyond.value > 0


def test_a_finest_change_above_a_tenth_of_the_scale_shows_no_order():
    assert converged({4 * H: 0.0, 2 * H: 0.5, H: 0.599}).outcome == "pass"
    assert converged({4 * H: 0.0, 2 * H: 0.5, H: 0.601}).outcome == "undecided"


def test_where_kinks_scatter_changes_they_are_within_the_sum_of_both_bounds():
    of = swinging((SPRING, RUBBING))
    noise = ROUND_OFF + U * 8 / H + 8 * U * 16 + U * 4 / H
    allowed = 17 * ((4 * H) ** 2 + (2 * H) ** 2) + noise
    beyond = converged({4 * H: 0.0, 2 * H: 0.0, H: 1.01 * allowed}, of=of)
    assert beyond.outcome == "fail"
    assert beyond.bound == near(allowed, **LIKE)
    assert beyond.value == near(1.01 * allowed, **LIKE)
    within = converged({4 * H: 0.0, 2 * H: 0.0, H: 0.99 * allowed}, of=of)
    assert within.outcome == "undecided"


# The way back


def back(defect, *, of=None, claims=None, known=None, levels=LEVELS, forward=0.0):
    """Findings of a reversal whose states come back off by `defect(variant)` of their scale."""
    of = of or swinging()
    subject = Subject(of, claims or method(), levels, known or known_of())

    def run(variant):
        place = np.array(standing(of).position)
        if variant.goes_on:
            place[-1, 0, 0] += 4 * defect(variant)
        else:
            place[-1, 0, 0] += 4 * forward
        return standing(of, position=place)

    return subject, findings(reversal.CHECK, subject, run)


def test_a_reversible_method_comes_back_to_round_off_of_both_ways():
    claims = method(reversible=True)
    _, found = back(
        lambda variant: 1e-3, claims=claims, known=known_of(growth=[1, 1, 1, 1, 3.0]), forward=1.0
    )
    each = sqrt(2.0) * ROUND_OFF
    reached = each * 3
    # One body in space has six columns: more than S = 3. Of S^2 = 1, 1, 1, 9 the root mean square.
    expected = 2 * (each * sqrt(21.0) + reached**2 * 3)
    assert found["reversed"].value == near(1e-3, **LIKE)
    assert found["reversed"].bound == near(expected, rel=1e-9)
    steep = known_of(growth=[1, 1, 1, 1, 100.0])
    _, found = back(lambda variant: 1e-3, claims=claims, known=steep, forward=1.0)
    grown = sqrt((3 + 600.0**2) / 4)
    expected = 2 * (each * grown + (each * 100) ** 2 * 100)
    assert found["reversed"].bound == near(expected, rel=1e-9)
    # A method that computes the end at once rounds there, where S is largest.
    exact = method("exact", reversible=True)
    _, found = back(lambda variant: 1e-3, claims=exact, known=steep, levels=(0.0,), forward=1.0)
    once = sqrt(2.0) * 8 * U * 16
    assert found["reversed"].bound == near(2 * (once * 600 + (once * 100) ** 2 * 100), rel=1e-9)


@pytest.mark.parametrize(("largest", "stretched"), [(1.0, 1.0), (40.0, 33.0)])
def test_roundings_of_equal_terms_stretch_the_motion_of_a_free_body(largest, stretched):
    free = instance([BALL], (), times=TIMES, quantities={"x": 4.0})
    known = known_of(growth=[1, largest, largest, largest, largest])
    _, found = back(lambda variant: 1e-3, of=free, claims=method(reversible=True), known=known)
    # Grown by S and six columns, S if it is 1, or as a time that is scaled: 1 + 2 T/tau.
    inverse = min(6.0, largest) * largest
    alike = U * 8 / H
    each = sqrt(2.0) * ROUND_OFF
    expected = 2 * (each * inverse + alike * stretched + ((each + alike) * largest) ** 2 * largest)
    assert found["reversed"].bound == near(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("omega", "turns"), [((0.0, 0.0, 2.0), 3.0), ((1.0, 1.0, 0.0), 0.0)], ids=["spins", "tumbles"]
)
def test_turns_of_a_body_that_spins_steadily_round_alike_at_every_step(omega, turns):
    body = Body(mass=2.0, inertia=(1.0, 2.0, 3.0), omega=omega)
    free = instance([body], (), times=TIMES, quantities={"x": 4.0})
    known = known_of(growth=[1, 1, 1, 1, 1.0])
    _, found = back(lambda variant: 1e-3, of=free, claims=method(reversible=True), known=known)
    alike = (1.0 + turns) * U * 8 / H
    each = sqrt(2.0) * ROUND_OFF
    assert found["reversed"].bound == near(2 * (each + alike + (each + alike) ** 2), rel=1e-9)


def test_the_way_back_may_add_as_much_as_the_way_forward_is_seen_to_have():
    claims = method(reversible=True)
    _, found = back(lambda variant: 0.0, claims=claims, known=known_of(growth=[1, 1, 1, 1, 3.0]))
    reached = 20 * ROUND_OFF
    seen = 2 * (reached * 3 + reached**2 * 3)
    each = sqrt(2.0) * ROUND_OFF
    claimed = 2 * (each * sqrt(21.0) + (each * 3) ** 2 * 3)
    assert found["reversed"].bound == near(min(seen, claimed), rel=1e-9)


@pytest.mark.parametrize(
    ("elements", "control", "room"),
    [
        ((SPRING,), "step", 4),
        ((SPRING, RUBBING), "step", 64),
        ((SPRING,), "tolerance", 4),
        # Steps that a tolerance makes beside a kink are others on the way back.
        ((SPRING, RUBBING), "tolerance", inf),
    ],
)
def test_the_error_that_is_seen_forward_has_room_for_kinks_in_fixed_steps(elements, control, room):
    of = swinging(elements)
    levels = LEVELS if control == "step" else (1e-4, 1e-6)
    subject = Subject(of, method(control), levels, known_of())
    compared = reversal._compared_level(subject, levels[-1])
    run = CompletedRun(wrong_by(of, {compared: 1e-6})(Variant(compared)), Cost(seconds=0.0))
    found = reversal._defect_from_observed_error(subject, {Variant(compared): run}, levels[-1])
    reached = room * 1e-6 + 20 * subject.noise(levels[-1])
    assert found == near(2 * (reached + reached**2), rel=1e-9)


@pytest.mark.parametrize(("elements", "part"), [((SPRING, RUBBING), 1.0), ((SPRING,), 0.0)])
def test_the_way_back_may_add_what_a_step_across_a_kink_is_off_by(elements, part):
    """x moves by 2 m of 4 m in the last 2 s, so a force that jumps leaves 4 h/(4 s) a step."""
    of = swinging(elements)
    subject = Subject(of, method(), LEVELS, known_of())
    moved = wrong_by(of, {H: np.array([0, 0, 0, 0, 0.5])})(Variant(H))
    run = CompletedRun(moved, Cost(seconds=0.0))
    found = reversal._defect_from_observed_error(subject, {Variant(H): run}, H)
    room = 4 if part == 0 else 64
    reached = room * 0.5 + 20 * subject.noise(H) + part * 4 * 0.25 * H
    assert found == near(2 * (reached + reached**2), rel=1e-9)


def test_a_defect_falls_with_the_order_from_a_larger_step():
    fine = 1e-6
    levels = (2 * H, H, H / 2)
    sizes = {H: 8 * fine, H / 2: fine}
    subject, found = back(lambda v: sizes.get(v.level, 0.0), levels=levels, forward=1.0)
    noise = 8 * U * sqrt(16 / H)
    assert found["reversed"].bound == near(4 * 8 * fine / 4 + 20 * noise, rel=1e-9)
    assert subject.levels[-1] == H / 2


def test_a_return_error_of_an_even_order_has_the_next_odd_one():
    levels = (2 * H, H, H / 2)
    for claimed, expected, ratio in ((2, 3, 4.2), (1, 1, 1.85), (3, 3, 7.6)):
        _, found = back(
            lambda v, r=ratio: 0.01 * r ** log2(2 * v.level / H),
            levels=levels,
            claims=method(order=claimed),
            forward=1.0,
        )
        assert found["order"].value == near(max(0.0, expected - log2(ratio)), **LIKE)
        assert found["order"].bound == near(0.15)
        verb = "meets" if found["order"].outcome == "pass" else "is below"
        assert f"{verb} the claimed {expected}" in found["order"].sentence


def test_the_order_of_a_return_error_is_read_at_the_finest_level_that_is_run_back():
    """A way back that is predictable only at finer levels than the way forward is run there."""
    levels = (2 * H, H, H / 2)

    def size(variant):
        # The coarse pair lacks a whole order, as one that is not yet of small steps.
        if variant.level >= H:
            return 0.0192
        return 0.018 * (2 * variant.level / H)

    _, found = back(size, levels=levels, claims=method(order=1), forward=1.0)
    assert found["order"].outcome == "pass"


def test_a_return_error_whose_one_pair_lacks_less_than_an_order_decides_nothing():
    """Terms may cancel: 2.58 and 4.36 were seen of methods whose next pairs show 3 and 5."""
    levels = (2 * H, H, H / 2)
    for ratio, outcome in ((2**2.14, "undecided"), (2**2.09, "fail"), (2**2.84, "undecided")):
        sizes = {H: ratio * 0.01, H / 2: 0.01}
        _, found = back(
            lambda v, s=sizes: s.get(v.level, 0.0),
            levels=levels,
            claims=method(order=2),
            forward=1.0,
        )
        assert found["order"].outcome == outcome, found["order"].sentence


def test_a_defect_below_the_next_term_shows_no_order():
    levels = (2 * H, H, H / 2)
    # C T/tau (h/tau)^4 = 16 H^4 with h = H/2, tau = 1/2.
    floor = 16 * H**4
    for factor, is_seen in ((0.99, False), (1.01, True)):
        sizes = {H: 8 * factor * floor, H / 2: factor * floor}
        _, found = back(lambda v, s=sizes: s.get(v.level, 0.0), levels=levels, forward=1.0)
        assert ("order" in found) == is_seen
    large = {H: 0.099, H / 2: 0.01}
    assert "order" in back(lambda v: large.get(v.level, 0.0), levels=levels, forward=1.0)[1]
    larger = {H: 0.101, H / 2: 0.01}
    assert "order" not in back(lambda v: larger.get(v.level, 0.0), levels=levels, forward=1.0)[1]


def test_a_state_that_comes_back_is_compared_in_its_scales_with_its_velocities_reversed():
    spinning = Body(mass=1.0, inertia=(0.1,) * 3, velocity=(8.0, 0, 0), omega=(0, 0, 2.0))
    of = instance([spinning], times=TIMES, quantities={"x": 4.0})
    subject = Subject(of, method(), LEVELS, known_of())

    def defect(change, sign, **off):
        run = standing(of)
        columns = {"velocity": sign * run.velocity, "omega": sign * run.omega}
        for name, value in off.items():
            columns[name] = columns.get(name, getattr(run, name)) + np.array(value)
        return reversal._defect(subject, standing(of, **columns), change)

    assert defect("reversed", -1.0) == defect("backward", 1.0) == 0.0
    assert defect("reversed", 1.0) == 2.0
    assert defect("backward", -1.0) == 2.0
    assert defect("backward", 1.0, position=(1.0, 0, 0)) == 0.25
    assert defect("backward", 1.0, velocity=(1.0, 0, 0)) == 0.125
    assert defect("backward", 1.0, omega=(0, 0, 0.5)) == 0.25
    run = standing(of)
    attitude = np.array(run.attitude)
    attitude[-1, 0] = [np.cos(0.2), 0, 0, np.sin(0.2)]
    assert reversal._defect(subject, standing(of, attitude=attitude), "backward") == near(0.4)
    still = instance([POINT], times=TIMES)
    point = Subject(still, method(), LEVELS, None)
    spun = standing(still, omega=np.full((5, 1, 3), 0.5))
    # Nothing turns at the start: omega in units of 1/tau = 2/s.
    assert reversal._defect(point, spun, "backward") == 0.25


def test_the_way_back_is_judged_at_the_first_step_at_which_it_is_predictable():
    # 2 (S + ...) 17 (2 h)^2 S at S = 1: 34 (2 h)^2 and its square; a tenth is at 2 h = 0.0523.
    levels = (2.0**-2, 2.0**-3, 2.0**-4)
    subject = Subject(swinging(), method(), levels, known_of())
    assert reversal._predictable_level(subject) == 2.0**-6
    assert (
        reversal._claimed_defect(subject, 2.0**-6)
        < 0.1
        < reversal._claimed_defect(subject, 2.0**-5)
    )
    far = Subject(swinging(), method(), (2.0,), known_of(growth=[1e9] * 5))
    assert reversal._predictable_level(far) == 2.0
    reached = 17 * (2.0**-5) ** 2 + subject.noise(2.0**-6)
    expected = 2 * (reached + reached**2)
    assert reversal._claimed_defect(subject, 2.0**-6) == near(expected, rel=1e-12)


@pytest.mark.parametrize(("forward", "quantity"), [(0.0, "reversed"), (1e-3, "return")])
def test_a_way_back_beyond_the_claims_is_decided_by_the_error_that_is_seen(forward, quantity):
    """At S = 1e9 the claims bound nothing at any step; a forward run without an error does."""
    steep = known_of(growth=[1, 1, 1, 1, 1e9])
    subject, found = back(lambda variant: 0.0, known=steep, levels=(H,), forward=forward)
    assert reversal._claimed_defect(subject, H) > 0.1
    assert list(found) == [quantity]


def test_a_bound_on_the_way_back_that_is_seen_forward_has_all_of_the_growth():
    steep = known_of(growth=[1, 1, 1, 1, 1e9])
    subject, found = back(lambda variant: 0.0, known=steep, levels=(H,))
    reached = 20 * subject.noise(H)
    assert found["reversed"].bound == near(2 * (reached * 1e9 + reached**2 * 1e9), rel=1e-9)


def test_a_tolerance_is_compared_with_the_one_before_it():
    subject = Subject(swinging(), method("tolerance"), (1e-4, 1e-6, 1e-8), known_of())
    assert reversal._compared_level(subject, 1e-8) == 1e-6
    assert reversal._compared_level(Subject(swinging(), method(), LEVELS, known_of()), H) == H


@pytest.mark.parametrize("name", ["order", "convergence", "limit"])
def test_a_coarse_step_that_is_exact_by_chance_has_an_order_and_warns_nobody(name):
    """As of a code that never takes longer steps than its own: runs at two steps are the same."""
    known = None if name == "convergence" else "certified"
    found = judged(name, {4 * H: 0.0, 2 * H: 0.0, H: 1e-3}, known=known)["state"]
    assert found.outcome in ("fail", "undecided"), found.sentence
    found = judged("order", {4 * H: 0.0, 2 * H: 1e-3, H: 1e-3})["state"]
    assert found.outcome == "fail", found.sentence
