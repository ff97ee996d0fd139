"""What all closed forms share, on a harmonic motion and on starts at which balls cannot decide."""

import re
from dataclasses import FrozenInstanceError, dataclass, field
from fractions import Fraction
from functools import partial
from math import cos, sin, sqrt

import pytest
from flint import arb, ctx

from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, nearest_integer, precision, refined
from refdem.truth.closed_form import ClosedForm, displaced_fields, larger, per_precision
from refdem.truth.closed_forms.free_rigid_body import FreeRigidBody
from refdem.truth.closed_forms.harmonic_oscillator import HarmonicOscillator
from refdem.truth.growth import Norm, SteadyGrowth, narrow
from refdem.truth.line_growth import linear
from refdem.truth.refiner import Refiner
from refdem.truth.sampled import sampled


@dataclass(frozen=True)
class Harmonic(ClosedForm):
    method = "cosine and sine"
    witness = "none"
    state = ("x", "v")

    x: Fraction
    v: Fraction
    hidden: bool = False
    prepared: list[int] = field(default_factory=list)

    displaced = displaced_fields("x", "v")

    @per_precision
    def start(self):
        self.prepared.append(ctx.prec)
        return arb_of(self.x), arb_of(self.v)

    def evaluate(self, t):
        if self.hidden and t > 1:
            raise UndecidedError("a boundary")
        x, v = self.start()
        return {"x": x * t.cos() + v * t.sin(), "v": v * t.cos() - x * t.sin()}

    @per_precision
    def growth(self):
        ratio = arb_of(self.scale["x"] / self.scale["v"])
        return SteadyGrowth(
            partial(linear, arb(1), -1, ratio), Norm([1, 1]), narrow(arb(1)), 2 * arb.pi()
        )

    def constants(self):
        return {"period": 2 * arb.pi()}


def harmonic(**more):
    return Harmonic(Refiner.of({"x": 0.5, "v": 0.25}), Fraction(1, 3), Fraction(1, 7), **more)


@pytest.mark.parametrize("digits", [10, 40, 60, 300])
def test_radii_fall_to_the_digits_asked_for(digits):
    value = harmonic().refined(digits).at(Fraction(5, 2))["x"]
    assert value.radius <= Fraction(1, 4) / 10**digits
    assert float(value.mid) == pytest.approx(cos(2.5) / 3 + sin(2.5) / 7, rel=1e-15)


def test_radii_are_held_against_the_smallest_scale():
    small = Harmonic(Refiner.of({"x": 1e-90, "v": 1.0}), Fraction(1), Fraction(0))
    assert small.at(Fraction(1))["x"].radius <= Fraction(1e-90) / 10**40


def test_sensitivity_is_the_largest_scaled_row_sum_of_the_flow_jacobian():
    # d(x/Lx, v/Lv)/d(x0/Lx, v0/Lv) = [[c, s Lv/Lx], [-s Lx/Lv, c]] with Lx/Lv = 2
    t = 0.75
    expected = max(cos(t) + sin(t) / 2, 2 * sin(t) + cos(t))
    assert expected <= harmonic().sensitivity(Fraction(t)) <= 1.2 * expected
    assert (
        sqrt(2)
        <= Harmonic(Refiner.of({"x": 1.0, "v": 1.0}), Fraction(0), Fraction(0)).sensitivity(
            Fraction(0.7853981633974483)
        )
        < 1.2 * sqrt(2)
    )


def test_work_done_at_a_precision_is_kept():
    truth = harmonic()
    truth.at(Fraction(1)), truth.at(Fraction(2))
    assert len(truth.prepared) == 1


def test_what_balls_cannot_decide_is_not_certified_and_samples_end_there():
    with pytest.raises(NotCertifiedError, match="t = 2 s"):
        harmonic(hidden=True).at(Fraction(2))
    found = sampled(harmonic(hidden=True), [0.0, 0.5, 1.0, 1.5, 2.0])
    assert found.until == 3
    assert len(found.values["x"]) == len(found.radii["v"]) == len(found.sensitivity) == 3
    assert "t = 1.5 s" in found.reason


def test_samples_are_doubles_whose_radii_contain_the_ball():
    truth = harmonic()
    found = sampled(truth, [0.0, 0.1, 3.0])
    assert found.until == 3
    assert found.reason == ""
    for i, t in enumerate(found.t):
        ball = truth.at(Fraction(t))["x"]
        assert abs(Fraction(found.values["x"][i]) - ball.mid) + ball.radius <= Fraction(
            found.radii["x"][i]
        )
        # sharp: a radius that is proved, in arithmetic that is the same everywhere
        assert found.radii["x"][i] < 1e-16
    assert found.scalars["period"][0] == 6.283185307179586


def test_precision_is_raised_while_a_branch_is_undecided():
    def needs_1000_bits():
        value = arb(2).sqrt() - 1 - (arb(3) - 2 * arb(2).sqrt()).sqrt()  # 0
        if not abs(value) < arb(2) ** -900:
            raise UndecidedError("too few bits")
        return {"zero": value}

    assert refined(needs_1000_bits, Fraction(1))["zero"].radius < Fraction(1, 2**900)
    assert refined(needs_1000_bits, Fraction(1), most=512) is None


def test_a_displaced_start_keeps_nothing_of_the_first_and_a_refined_truth_keeps_all():
    first = harmonic()
    first.at(Fraction(1))
    moved = first.displaced(0, Fraction(1, 6))
    assert (moved.x, moved.v, moved.kept) == (Fraction(1, 2), first.v, {})
    assert moved.scale == first.scale
    assert first.refined(60).kept is first.kept


def test_a_start_is_displaced_in_one_coordinate_of_a_tuple():
    assert larger((Fraction(1), Fraction(2)), 1, Fraction(1, 3)) == (Fraction(1), Fraction(7, 3))


def test_a_truth_cannot_be_altered():
    with pytest.raises(FrozenInstanceError):
        harmonic().x = Fraction(2)


def test_nearest_integer_is_that_of_the_midpoint():
    with precision(64):
        assert nearest_integer(arb("-2.6", 0.3)) == -3
        assert nearest_integer(arb("1e15") + arb("0.4")) == 10**15


@pytest.mark.parametrize(
    ("inertia", "omega", "wrong"),
    [
        ((1, 2, 3), (Fraction(1), Fraction(2), Fraction(3)), "1 in inertia"),
        ((Fraction(1),) * 3, (0.1, Fraction(2), Fraction(3)), "0.1 in omega"),
    ],
)
def test_numbers_that_would_be_rounded_are_refused(inertia, omega, wrong):
    unit = tuple(map(Fraction, (1, 0, 0, 0)))
    with pytest.raises(TypeError, match=re.escape(wrong) + ".*expected exact numbers such as"):
        FreeRigidBody(Refiner.of({"omega.x": 1.0}), inertia, omega, unit)


def test_scales_may_be_floats_and_named_numbers_are_looked_at():
    with pytest.raises(TypeError, match="HarmonicOscillator got 1 in mass"):
        HarmonicOscillator(
            refiner=Refiner.of({"x": 1.0}),
            mass=1,
            stiffness=Fraction(2),
            gravity=Fraction(0),
            x0=Fraction(1),
            v0=Fraction(0),
        )
    HarmonicOscillator(
        refiner=Refiner.of({"x": 1.0, "v": 0.1}),
        mass=Fraction(1),
        stiffness=Fraction(2),
        gravity=Fraction(0),
        x0=Fraction(1),
        v0=Fraction(0),
    )
