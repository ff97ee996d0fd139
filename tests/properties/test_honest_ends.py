"""Where nothing can be proved the error has code, time and last state; costs are said before; what
was given is proved again.
"""

from dataclasses import dataclass
from fractions import Fraction

import pytest
from flint import arb

from refdem.certification.reproof import given_of
from refdem.core import discovery
from refdem.errors import NotCertifiedError
from refdem.truth import load
from refdem.truth.balls import UndecidedError, precision
from refdem.truth.closed_form import ClosedForm
from refdem.truth.closed_forms import duffing
from refdem.truth.escape import Repulsion
from refdem.truth.events.crossing import SwitchError
from refdem.truth.events.truth import LADDER
from refdem.truth.forecast import FEW_PIECES, PIECES, Course, Mark, heavier
from refdem.truth.refiner import Refiner
from refdem.truth.validated_flow import ValidatedFlow, never
from tests.truth.events.systems import flow, swinging


@dataclass(frozen=True)
class Torn(ClosedForm):
    """Undecided after t = 1; after t = 2 known to 0.1."""

    state = ("x",)

    def evaluate(self, t):
        if t > 2:
            return {"x": arb(1, 0.1)}
        if t > 1:
            raise UndecidedError("a boundary")
        return {"x": arb(1) + t}

    def growth(self):
        raise UndecidedError("a boundary")

    def displaced(self, axis, amount):
        return self


def ended(truth, t):
    with pytest.raises(NotCertifiedError) as caught:
        truth.at(Fraction(t))
    return caught.value


def test_an_undecided_branch_is_a_separatrix_with_the_start_as_last_state():
    error = ended(Torn(Refiner.of({"x": 1.0})), "3/2")
    assert (error.code, error.time) == ("separatrix", 0.0)
    assert error.state["x"].mid == 1


def test_a_radius_that_stays_is_precision_with_its_ball():
    error = ended(Torn(Refiner.of({"x": 1.0})), 3)
    assert (error.code, error.time) == ("precision", 3.0)
    assert Fraction(9, 100) < error.state["x"].radius < Fraction(11, 100)


def ends_at_a_pole(y):
    """When x' = x^2 is infinite: x is 1/(1/x0 - t)."""
    if y[0] > 0:
        return 1 / y[0]
    return None


def squares(escape):
    """x' = x^2 from 1, which ends at t = 1; that it does is proved, or not."""
    return ValidatedFlow(
        lambda y: [y[0] * y[0]],
        [Fraction(1)],
        lambda y: {"x": y[0]},
        {"x": 1.0},
        state=("x",),
        moved=(0,),
        digits=10,
        escape=escape,
    )


@pytest.mark.parametrize(("escape", "code"), [(ends_at_a_pole, "singular"), (never, "precision")])
def test_a_motion_that_runs_into_a_pole_is_singular_only_where_that_is_proved(escape, code):
    error = ended(squares(escape), 2)
    assert error.code == code
    assert 0.99 < error.time < 1
    low, high = (error.state["x"].mid + sign * error.state["x"].radius for sign in (-1, 1))
    assert low <= 1 / (1 - Fraction(error.time)) <= high


def test_precision_is_raised_once_and_no_more_where_the_end_does_not_move():
    flow = squares(never)
    ended(flow, 2)
    assert sorted(flow.ends) == [64, 128]


@pytest.mark.parametrize(
    ("t", "given"),
    [
        ("18", {"damping": "3", "omega_body": "1.3,-0.7,0.4"}),
        ("40", {"damping": "1", "inertia": "2,2,3"}),
        # Spins have died out below all digits that are asked for.
        ("30", {"damping": "2", "inertia": "3,2,1", "omega_body": "1/3,1,-2"}),
        ("3", {"damping": "40"}),
    ],
)
def test_a_body_that_settles_about_an_axis_is_certified_long_after_and_keeps_angular_momentum(
    t, given
):
    instance = discovery.case("dissipating-body").at(**given)
    truth = instance.truth()
    balls = truth.at(Fraction(t))
    assert all(ball.radius <= Fraction(1, 10**40) for ball in balls.values())
    momentum = [
        sum((j * w) ** 2 for j, w in zip(instance.p["inertia"], omega, strict=True))
        for omega in (instance.p["omega_body"], mids(balls))
    ]
    assert abs(momentum[1] / momentum[0] - 1) < Fraction(1, 10**38)


def mids(balls):
    """Midpoints of the three components."""
    return [ball.mid for ball in balls.values()]


@pytest.mark.parametrize(
    ("case", "given"),
    [
        ("driven-duffing", {"beta": "-1", "f0": "9", "x0": "0", "v0": "0"}),
        ("driven-duffing", {"beta": "-1/2", "f0": "-7", "x0": "3/10", "v0": "0", "delta": "0"}),
        ("quadratic-response", {"eps": "1", "f0": "3,3", "x0": "0"}),
        ("quadratic-response", {"eps": "-3", "f0": "3,3", "x0": "0"}),
    ],
)
def test_an_oscillator_that_a_drive_throws_out_of_its_well_is_proved_to_be_infinite_soon(
    case, given
):
    error = ended(discovery.case(case).at(**given).truth(), 100)
    assert error.code == "singular"
    assert "infinite before" in str(error)
    earlier = discovery.case(case).at(**given).truth().at(Fraction(error.time) * Fraction(99, 100))
    assert all(ball.radius < Fraction(1, 10**30) for ball in earlier.values())
    assert set(error.state) == {"x", "v"}


def test_a_start_that_the_spring_draws_back_is_not_called_infinite():
    """Below the rim of the well, moving inward, or too slow against the damping."""
    well = Repulsion(3, Fraction(1), Fraction(4), Fraction(1, 2), Fraction(1))
    assert well.infinite_within(arb(1), arb(1)) is None
    assert well.infinite_within(arb(100), arb(-1)) is None
    assert well.infinite_within(arb(-100), arb(1)) is None
    assert well.infinite_within(arb(100), arb(10**4)) < 1


def test_the_time_to_infinity_bounds_that_of_a_spring_that_is_solved():
    """z'' = 2 z^3 with z' = z^2 at z = 1 is z = 1/(1 - t); the bound must lie beyond t = 1 and near
    it.
    """
    bound = Repulsion(3, Fraction(2), Fraction(0), Fraction(0), Fraction(0)).infinite_within(
        arb(1), arb(1)
    )
    assert 1 < bound < 2


def test_a_duffing_oscillator_above_its_escape_energy_is_singular():
    with pytest.raises(NotCertifiedError) as caught:
        duffing.truth(
            {"alpha": Fraction(1), "beta": Fraction(-1), "amplitude": Fraction(2)},
            {"x": 1.0, "v": 1.0},
        ).at(Fraction(1))
    assert caught.value.code == "singular"


def test_multipliers_of_a_slow_drive_end_as_precision_and_the_motion_does_not():
    truth = discovery.case("kapitza-pendulum").at(drive="1/100").truth()
    with pytest.raises(NotCertifiedError) as caught:
        truth.scalars()
    assert caught.value.code == "precision"
    assert truth.at(Fraction(1, 8))["theta"].radius < Fraction(1, 10**38)


def test_stiff_and_fast_motions_have_discs():
    for name, t, given in (
        ("driven-duffing", "1/64", {"delta": "200"}),
        (
            "kapitza-pendulum",
            "1/64",
            {"length": "3/5", "drive_amplitude": "3/5", "theta0": "-5/64"},
        ),
    ):
        balls = discovery.case(name).at(**given).truth().at(Fraction(t))
        assert all(ball.radius < Fraction(1, 10**38) for ball in balls.values())


def test_a_motion_through_events_says_what_it_will_cost_and_is_not_displaced():
    truth = discovery.case("stick-slip").at().truth()
    assert truth.forecast(Fraction(1, 64), 40) == 0
    near, far = (truth.proof.foreseen(Fraction(t), Course(LADDER[0])) for t in (60, 600))
    assert 2 < far / near < 50
    with pytest.raises(NotCertifiedError, match="variational"):
        truth.displaced(0, Fraction(1))
    with pytest.raises(NotCertifiedError, match="fewer"):
        truth.refined(900).at(Fraction(1, 64))


@pytest.mark.parametrize(
    ("case", "given", "t", "digits"),
    [
        ("stick-slip", {}, 47, 60),
        # It sticks at first, which costs nothing, and then slips and sticks by turns.
        ("stick-slip", {"gamma": "0.609", "eta": "1.094", "belt": "-0.87"}, "58.37", 20),
        ("stick-slip", {"gamma": "0.532", "eta": "2.637", "belt": "-0.75"}, "18.49", 60),
        ("stick-slip", {"gamma": "0.179", "eta": "0.507", "belt": "0.641"}, "54.57", 40),
        # It begins to slip, and is about to stick, where no scout goes on.
        ("stick-slip", {"a": "14.94"}, "99.01", 41),
        # It flies, and the proof needs more bits than the set at the end of a piece tells.
        ("neglected-gyroscopic", {"member": "slope"}, "0.02", 40),
        ("neglected-gyroscopic", {"member": "slope"}, "0.1", 40),
    ],
)
def test_a_forecast_through_events_is_within_a_factor_of_three_in_pieces(case, given, t, digits):
    """Counted work, no clock: what is left after the forecast has followed its share."""
    truth = discovery.case(case).at(**given).truth().refined(digits)
    course = Course(truth.proof.needed()[0], has_events=True)
    told = truth.proof.foreseen(Fraction(t), course)
    made = course.marks[-1].pieces
    truth.at(Fraction(t))
    work = 0.0
    for key, motion in truth.proof.kept.items():
        pieces = sum(len(phase.pieces) for phase in motion.phases)
        work += pieces * heavier(key[1], course.bits)
    left = work - made
    # A motion that is all but followed has nothing left to be wrong about.
    assert told / 3 - PIECES < left < 3 * told + PIECES


def test_a_forecast_knows_of_the_contact_that_a_flight_ends_with():
    """Counted work, no clock: eight pieces of flight before it, of which four are made, and then
    some thirty of the contact.
    """
    truth = discovery.case("neglected-gyroscopic").at(member="slope").truth().refined(12)
    course = Course(truth.proof.needed()[0], has_events=True)
    t = Fraction("0.1294")
    told = truth.proof.foreseen(t, course)
    made = course.marks[-1].pieces
    assert made == FEW_PIECES
    truth.at(t)
    [motion] = [motion for key, motion in truth.proof.kept.items() if key[0] == "motion"]
    assert motion.events
    left = sum(len(phase.pieces) for phase in motion.phases) - made
    assert told / 2 < left < 2 * told


def test_a_motion_that_ends_while_it_is_followed_costs_nothing_more():
    """A swing of amplitude 1 touches the level 1, which no bits tell from a crossing."""
    truth = flow(swinging(Fraction(1)), [Fraction(0), Fraction(1), 0], "swing")
    t = Fraction(1000)
    course = Course(LADDER[1], has_events=True)
    assert truth.proof.foreseen(t, course) == 0
    assert course.marks[-1].time < 2
    with pytest.raises(NotCertifiedError, match="grazing"):
        truth.at(t)


def test_the_pace_of_a_motion_through_events_is_that_from_entry_to_entry_into_one_mode():
    """It slips for 1 s with 10 pieces, and sticks for 9 s with none: a piece a second."""
    marks = [
        Mark(0.0, 0, 0.0, -90.0),
        Mark(1.0, 10, 10.0, -90.0),
        Mark(10.0, 10, 10.0, -90.0),
        Mark(11.0, 20, 20.0, -90.0),
        Mark(20.0, 20, 20.0, -90.0),
        Mark(20.5, 25, 25.0, -90.0),
    ]
    entries = [("stick", 1), ("slip", 2), ("stick", 3), ("slip", 4)]
    course = Course(100, marks, has_events=True, entries=entries)
    assert course.has_pace()
    assert course.pieces_since() == 5
    assert course.work_to(60.0, -80.0, lambda bits, lacking: None) == pytest.approx(35.0)
    assert not Course(100, marks[:3], has_events=True, entries=entries[:2]).has_pace()
    assert Course(100, marks[:3]).has_pace()


def test_where_s_is_not_known_it_says_why_and_from_where_on():
    with pytest.raises(NotCertifiedError, match="no sensitivity") as caught:
        Torn(Refiner.of({"x": 1.0})).sensitivity(Fraction(3, 2))
    assert (caught.value.code, caught.value.time, caught.value.state["x"].mid) == (
        "separatrix",
        0.0,
        1,
    )


def test_s_of_a_motion_through_events_ends_where_the_motion_does():
    """S is asked for first: nothing of the motion is known yet."""
    given = {
        "spins": "1,3,1,2,-1,3",
        "angle": "1/3",
        "tangential_stiffness": "512",
        "friction": "1/64",
        "damping": "0",
    }
    for ask in (
        lambda truth, t: truth.sensitivity(t),
        lambda truth, t: truth.sensitivities([Fraction(0), t]),
    ):
        with pytest.raises(NotCertifiedError, match=r"S at t = [01] s") as caught:
            ask(discovery.case("two-spheres").at(**given).truth(), Fraction(1))
        assert (caught.value.code, caught.value.time, caught.value.state["omega1.y"].mid) == (
            "singular",
            0.0,
            3,
        )


def test_a_time_within_an_event_has_the_entry_before_it_as_last_state():
    truth = discovery.case("stick-slip").at(x0="3", v0="-2").truth()
    truth.events_until(Fraction(5))
    motion = truth.motion(LADDER[0])
    with precision(LADDER[0]), pytest.raises(SwitchError, match="uncertainty") as caught:
        motion.phase(motion.events[0].time)
    error = truth.proof.uncertified(caught.value, "S")
    assert (error.code, error.time, error.state["x"].mid) == ("precision", 0.0, 3)


def test_members_are_proved_again_with_what_was_given_alone():
    for one in load("impact-benchmarks"):
        given = given_of(one)
        assert set(given) <= {
            "member",
            "angle",
            "partner_spin",
            "branch",
            "restitution",
            "friction",
            "radius",
            "speed",
            "cutoff",
            "spin",
        }
        assert discovery.case(one.case).at(**given).label == one.label
