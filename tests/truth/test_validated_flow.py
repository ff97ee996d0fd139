"""A Truth by validated integration: radii as asked for, S from the variational equation against
closed forms and displaced starts.
"""

from dataclasses import replace
from fractions import Fraction

import pytest
from flint import arb

from refdem.core.discovery import truth_of
from refdem.truth.balls import arb_of, precision
from refdem.truth.forecast import PIECES, Course, Mark, heavier
from refdem.truth.growth import WIDEST
from refdem.truth.validated_flow import ValidatedFlow
from tests.truth.validated_ivp.fields import harmonic, pendulum, van_der_pol


def flow(rule, start, quantities, scale, digits=40):
    return ValidatedFlow(
        rule, start, quantities, scale, state=("x", "v"), moved=(0, 1), digits=digits
    )


def named(y):
    """Position, velocity and energy of an oscillator."""
    return {"energy": (y[0] * y[0] + y[1] * y[1]) / 2, "x": y[0], "v": y[1]}


def test_quantities_have_the_radius_asked_for_at_any_time():
    truth = flow(
        harmonic,
        [Fraction(1, 3), Fraction(0)],
        named,
        {"x": 1.0, "v": 1.0, "energy": 0.1},
        digits=70,
    )
    found = truth.at(Fraction(7, 3))
    with precision(400):
        assert abs(arb_of(found["x"].mid) - arb_of(Fraction(7, 3)).cos() / 3) <= arb_of(
            found["x"].radius
        )
    assert abs(found["energy"].mid - Fraction(1, 18)) <= found["energy"].radius
    assert all(ball.radius <= Fraction(1, 10**71) for ball in found.values())


def test_sensitivity_of_an_oscillator_is_that_of_a_rotation():
    truth = flow(
        harmonic, [Fraction(1), Fraction(0)], lambda y: {"x": y[0], "v": y[1]}, {"x": 1.0, "v": 4.0}
    )
    t = arb(2)
    # |cos s| + 4 sin s has been largest at s = atan 4 already: errors that are made later have not
    # turned so far.
    assert float(t.cos() ** 2) < 1
    assert 17**0.5 <= truth.sensitivity(Fraction(2)) <= 1.2 * 17**0.5


def test_a_pendulum_and_its_growth_are_those_of_the_elliptic_functions():
    closed = truth_of("pendulum", theta0="3", thetadot0="1", gravity="1", length="1")
    scale = {"x": float(closed.scale["theta"]), "v": float(closed.scale["thetadot"])}
    truth = flow(pendulum, [Fraction(3), Fraction(1)], lambda y: {"x": y[0], "v": y[1]}, scale)
    times = [Fraction(0), Fraction(5, 4), Fraction(4)]
    ball = truth.at(times[-1])["v"]
    other = closed.at(times[-1])["thetadot"]
    assert abs(ball.mid - other.mid) <= ball.radius + other.radius
    displaced = (
        truth.displaced(1, Fraction(1, 10**20)).at(times[-1])["x"].mid
        - truth.at(times[-1])["x"].mid
    )
    slope = float(truth.jacobian(times[-1])[0, 1].mid()) * scale["x"] / scale["v"]
    assert float(displaced) * 1e20 == pytest.approx(slope, rel=1e-9)
    assert truth.sensitivities(times)[-1] == truth.sensitivity(times[-1])


def test_growth_of_errors_made_on_the_way_is_that_of_the_elliptic_functions():
    closed = truth_of("pendulum", theta0="3", thetadot0="0", gravity="1", length="1")
    scale = {"x": float(closed.scale["theta"]), "v": float(closed.scale["thetadot"])}
    sizes = closed.scale | dict.fromkeys(("x", "y", "rod_force"), Fraction(10**9))
    only = replace(closed, refiner=replace(closed.refiner, scale=sizes))
    truth = flow(pendulum, [Fraction(3), Fraction(0)], lambda y: {"x": y[0], "v": y[1]}, scale)
    times = [Fraction(k, 2) for k in range(24)]
    found = truth.sensitivities(times)
    # Both are bounds of one number, each within the width of a cell of it.
    assert found == pytest.approx(only.sensitivities(times), rel=WIDEST)


def test_growth_of_a_damped_motion_needs_no_inverse_of_what_has_died_out():
    truth = flow(
        lambda y: [y[1], -y[0] * 26 - y[1] * 10],
        [Fraction(1), Fraction(0)],
        lambda y: {"x": y[0], "v": y[1]},
        {"x": 1.0, "v": 5.0},
    )
    times = [Fraction(k) for k in range(0, 41, 4)]
    # exp(-5 s) (cos s + ...): every error dies out, those of the last moments are the largest
    found = truth.sensitivities(times)[1:]
    assert found == pytest.approx([found[0]] * 10, rel=WIDEST)
    assert 1 < found[0] < 2


def test_bits_are_those_that_the_digits_need_and_are_kept():
    truth = flow(
        lambda y: [y[1], y[0]],
        [Fraction(1), Fraction(0)],
        lambda y: {"x": y[0], "v": y[1]},
        {"x": 1.0, "v": 1.0},
        digits=30,
    )
    assert truth.at(Fraction(1))["x"].radius <= Fraction(1, 10**30)
    assert [key[1] for key in truth.kept if key[0] == "integration"] == [128]
    with precision(400):
        assert abs(arb_of(truth.at(Fraction(40))["x"].mid) - arb(40).cosh()) < 1e-30
    kept = [key[1] for key in truth.kept if key[0] == "integration"]
    assert len(kept) == 2
    assert kept[1] < 300
    assert truth.at(Fraction(39))["x"].radius <= Fraction(1, 10**30)
    assert [key[1] for key in truth.kept if key[0] == "integration"] == kept


def weighed(truth, first, made):
    """The pieces of all precisions beyond those made for the forecast, those of more bits at their
    weight.
    """
    found = {
        key[1]: len(flow.pieces) for key, flow in truth.kept.items() if key[0] == "integration"
    }
    return sum(count * heavier(bits, first) for bits, count in found.items()) - made


@pytest.mark.parametrize(
    ("case", "given", "t", "digits"),
    [
        ("van-der-pol", {}, 40, 40),
        ("van-der-pol", {"mu": "5"}, 25, 40),
        ("driven-duffing", {}, 40, 100),
        ("dissipating-body", {"damping": "3", "omega_body": "1.3,-0.7,0.4"}, 18, 40),
        ("pendulum-wheel-mass", {}, 15, 40),
        ("double-pendulum", {}, 4, 40),
        ("heavy-top", {}, 4, 40),
        # Starts slowly, and whips later on.
        ("double-pendulum", {"masses": "1,100", "lengths": "1,0.1"}, "0.6", 40),
    ],
)
def test_a_forecast_is_within_a_factor_of_three_in_pieces(case, given, t, digits):
    """Counted work, no clock: what is left after the forecast has followed its share."""
    truth = truth_of(case, **given).refined(digits)
    course = Course(truth.bits())
    told = truth.foreseen(Fraction(t), course)
    made = course.marks[-1].pieces
    truth.at(Fraction(t))
    left = weighed(truth, course.bits, made)
    # A motion that is all but followed has nothing left to be wrong about.
    assert told / 3 - PIECES < left < 3 * told + PIECES
    assert made <= max(PIECES + 1, told)


@pytest.mark.parametrize(
    ("case", "given", "t"),
    [
        # Its spins settle: the series go far, and what a disc may be is what limits a piece.
        ("dissipating-body", {"damping": "0.492", "omega_body": "-3.23,-2.897,1.427"}, 20),
        # More bits are needed for the radius within the last piece, not for that at its end.
        ("heavy-top", {"theta0": "2.08", "spin": "21.643"}, 3),
    ],
)
def test_a_forecast_knows_the_widest_disc_and_the_radius_within_a_piece(case, given, t):
    """Counted work, no clock, within a factor of 1.6: without either it is 2 to 3 times too low."""
    truth = truth_of(case, **given)
    course = Course(truth.bits())
    told = truth.foreseen(Fraction(t), course)
    made = course.marks[-1].pieces
    truth.at(Fraction(t))
    left = weighed(truth, course.bits, made)
    assert told / 1.6 < left < 1.6 * told


def test_a_forecast_of_a_motion_that_was_followed_is_nothing_and_grows_with_the_time():
    truth = flow(
        van_der_pol,
        [Fraction(2), Fraction(0)],
        lambda y: {"x": y[0], "v": y[1]},
        {"x": 1.0, "v": 1.0},
    )
    truth.at(Fraction(12))
    assert truth.forecast(Fraction(12), 40) == 0
    near, far = (truth.foreseen(Fraction(t), Course(truth.bits())) for t in (40, 400))
    assert 5 * near < far < 30 * near
    assert truth.forecast(Fraction(12), 400) > 0


def test_the_radius_of_a_forecast_is_that_of_the_quantities():
    """The set of x has a radius; that of 1000 x is a thousand times as large."""
    truth = flow(
        harmonic,
        [Fraction(1), Fraction(0)],
        lambda y: {"x": y[0], "v": y[1], "energy": y[0] * 1000},
        {"x": 1.0, "v": 1.0, "energy": 0.1},
    )
    with precision(truth.first_bits()):
        integration = truth.integration()
        integration.advance()
        of_set = max(float(radius) for radius in integration.spread.radii())
        assert 300 * of_set < float(truth.radius_of(integration)) < 3000 * of_set


def test_seconds_are_those_of_the_pieces_that_were_made():
    course = Course(
        100,
        [
            Mark(0.0, 0, 0.0, -90.0),
            Mark(1.0, 9, 9.0, -90.0),
            Mark(2.0, 19, 19.0, -90.0),
            Mark(4.0, 29, 24.0, -90.0),
        ],
    )
    assert course.pieces_to(8.0) == pytest.approx(20.0)
    assert course.seconds_for(20.0) == pytest.approx(10.0)
    assert course.work_to(8.0, -80.0, lambda bits, lacking: None) == pytest.approx(20.0)


def test_a_motion_with_a_clock_goes_on_at_the_pace_by_the_clock():
    """Ten pieces a unit of t^2: from t = 2 to 4 there are 120 more."""
    course = Course(
        100,
        [Mark(0.0, 0, 0.0, -80.0), Mark(1.0, 10, 1.0, -79.0), Mark(2.0, 40, 4.0, -76.0)],
        clock=lambda t: t**2,
    )
    assert course.work_to(4.0, 0.0, lambda bits, lacking: None) == pytest.approx(120.0)
    assert course.seconds_for(120.0) == pytest.approx(12.0)
    assert course.radius_at(course.clock(4.0)) == pytest.approx(-64.0)


def test_a_forecast_sees_the_bits_that_sets_lose_by_wrapping_whip_after_whip():
    """The whole proof makes 803 pieces at 160 bits, whose radius is too large in the end, and 788
    at 200 bits. An error that is there hardly grows: the sets wrap.
    """
    truth = truth_of("double-pendulum", masses="1,100", lengths="1,0.1")
    course = Course(truth.bits())
    told = truth.foreseen(Fraction(2), course)
    assert course.bits == 160
    work = 803 + 788 * heavier(200, 160)
    assert work / 1.6 < told + course.marks[-1].pieces < 1.6 * work


def test_what_an_error_will_do_is_foreseen_and_what_the_proof_adds_goes_on():
    """The error has grown by 6 of 10 bits, and stays from now on; 4 bits a second go on."""
    course = Course(
        100,
        [Mark(0.0, 0, 0.0, -90.0), Mark(1.0, 10, 1.0, -80.0), Mark(2.0, 20, 2.0, -70.0)],
        swelling=lambda t: 6.0 * min(t, 2.0),
    )
    assert course.radius_at(7.0) == pytest.approx(-50.0)
    assert course.time_of(-60.0, 7.0) == pytest.approx(4.5)


def test_a_motion_that_loses_bits_is_counted_again_with_more():
    """10 bits a second from 2^-80: at t = 8 the radius is 1, and 100 bits do not come farther than
    t = 5.6.
    """
    course = Course(
        100, [Mark(0.0, 0, 0.0, -80.0), Mark(1.0, 10, 1.0, -70.0), Mark(2.0, 20, 2.0, -60.0)]
    )
    assert course.radius_at(8.0) == pytest.approx(0.0)
    assert course.time_of(-24.0, 8.0) == pytest.approx(5.6)
    once = course.work_to(8.0, -60.0, lambda bits, lacking: None)
    assert once == pytest.approx(36.0)
    twice = course.work_to(8.0, -60.0, lambda bits, lacking: 2 * bits if bits == 100 else None)
    assert twice == pytest.approx(36.0 + 80.0 * heavier(200, 100))


def test_what_a_set_does_that_is_too_large_is_not_the_pace_of_a_thinner_one():
    """Ten pieces and ten bits a second up to 2^-30; then the set is too large for 100 bits, and
    hundreds of pieces come no farther. With 200 bits there are 100 pieces to t = 10.
    """
    thin = [Mark(float(t), 10 * t, float(t), -80.0 + 10 * t) for t in range(6)]
    large = [Mark(5.6, 20, 5.6, -20.0), Mark(5.7, 200, 20.0, 0.0), Mark(5.71, 500, 50.0, 30.0)]
    course = Course(100, thin + large)
    work = course.work_to(10.0, -60.0, lambda bits, lacking: 2 * bits if bits == 100 else None)
    assert work == pytest.approx(100.0 * heavier(200, 100))


def test_where_bits_may_or_may_not_suffice_half_of_the_work_with_more_is_counted():
    """A bit too few or too many is less than a forecast knows: the work is the same, about."""
    course = Course(100, [Mark(float(t), 20 * t, float(t), -90.0 + t) for t in range(3)])

    def work(target):
        return course.work_to(10.0, target, lambda bits, lacking: 2 * bits if bits == 100 else None)

    radius = course.radius_at(10.0)
    enough = 160.0
    more = 200.0 * heavier(200, 100)
    assert work(radius) == pytest.approx(enough + more / 2)
    assert work(radius - 1) < 1.4 * work(radius + 1)
    assert work(radius - 20) == pytest.approx(enough + more)
    assert work(radius + 20) == pytest.approx(enough)


def test_a_state_costs_no_further_piece_once_its_piece_exists():
    truth = flow(harmonic, [Fraction(1), Fraction(0)], named, {"x": 1.0, "v": 1.0, "energy": 0.1})
    truth.at(Fraction(20))

    def pieces() -> list[int]:
        """How many pieces every integration has made."""
        return [len(made.pieces) for key, made in truth.kept.items() if key[0] == "integration"]

    before = pieces()
    assert before
    for k in range(200):
        truth.at(Fraction(k, 10))
    assert pieces() == before
