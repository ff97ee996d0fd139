"""Coulomb oscillator: against turning points by hand, the equation of motion, the energy balance
and displaced starts.
"""

from fractions import Fraction
from itertools import pairwise

import pytest

from refdem.errors import NotCertifiedError
from refdem.truth.closed_forms.coulomb_oscillator import CoulombOscillator, truth
from refdem.truth.refiner import Refiner

DEFAULTS = {"mass": "1", "stiffness": "1", "friction_force": "0.15", "x0": "1", "v0": "0"}
SCALE = {"x": 1.0, "v": 1.0}
TINY = Fraction(1, 10**35)
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459")


def oscillator(**given):
    return truth({name: Fraction(text) for name, text in {**DEFAULTS, **given}.items()}, SCALE)


def state(truth, t):
    balls = truth.at(t)
    assert all(ball.radius <= Fraction(1, 10**40) for ball in balls.values())
    return balls["x"].mid, balls["v"].mid


@pytest.mark.parametrize(
    ("half_cycles", "place"), [(0, "1"), (1, "-0.7"), (2, "0.4"), (3, "-0.1"), (4, "-0.1")]
)
def test_default_turning_points_are_those_of_the_chapter(half_cycles, place):
    x, v = state(oscillator(), half_cycles * PI)
    assert abs(x - Fraction(place)) < TINY
    assert abs(v) < TINY


def test_it_stops_after_three_half_cycles_at_three_pi_and_never_moves_again():
    stopped = oscillator()
    scalars = stopped.scalars()
    assert scalars["stop_time"].decimals(40)[0].startswith("9.4247779607693797153879301498")
    assert abs(scalars["stop_position"].mid + Fraction(1, 10)) < TINY
    assert scalars["half_cycles"].rounded() == (3.0, 0.0)
    for t in (Fraction(10), Fraction(10**9)):
        ball = stopped.at(t)["v"]
        assert (ball.mid, ball.radius) == (0, 0)
        assert abs(state(stopped, t)[0] + Fraction(1, 10)) < TINY


@pytest.mark.parametrize("x0", ["0.15", "-0.15", "0.1", "0"])
def test_started_at_rest_where_friction_holds_it_stays(x0):
    still = oscillator(x0=x0)
    assert abs(state(still, Fraction(7))[0] - Fraction(x0)) < TINY
    assert still.scalars()["half_cycles"].rounded() == (0.0, 0.0)


def test_the_boundary_of_sticking_is_closed():
    assert oscillator(x0="0.45").scalars()["half_cycles"].mid == 1
    assert oscillator(x0="0.450000000000000000000000000001").scalars()["half_cycles"].mid == 2
    assert oscillator(x0="-0.75").scalars()["half_cycles"].mid == 2


@pytest.mark.parametrize(
    "given",
    [{}, {"x0": "-1", "v0": "0.3"}, {"x0": "0.2", "v0": "2", "mass": "3", "stiffness": "5"}],
)
def test_sliding_obeys_the_equation_of_motion(given):
    truth = oscillator(**given).refined(60)
    p = {name: Fraction(text) for name, text in {**DEFAULTS, **given}.items()}
    h = Fraction(1, 2**50)
    for t in (Fraction(1, 3), Fraction(2), Fraction(4), Fraction(11, 2)):
        (x_before, _), (x, v), (x_after, _) = (state(truth, t + by) for by in (-h, 0, h))
        acceleration = (x_before - 2 * x + x_after) / h**2
        friction = p["friction_force"] * (1 if v > 0 else -1)
        assert v != 0
        assert abs(p["mass"] * acceleration + friction + p["stiffness"] * x) < Fraction(1, 10**25)
        assert abs((x_after - x_before) / (2 * h) - v) < Fraction(1, 10**25)


def test_energy_lost_is_friction_times_path_also_from_a_moving_start():
    moving = oscillator(x0="-1", v0="0.3")
    times = [Fraction(n, 100) for n in range(1500)]
    path = sum(abs(state(moving, b)[0] - state(moving, a)[0]) for a, b in pairwise(times))
    x, v = state(moving, times[-1])
    lost = (Fraction("0.3") ** 2 + 1 - v**2 - x**2) / 2
    assert v == 0
    assert float(lost) == pytest.approx(0.15 * float(path), abs=1e-4)


def test_a_moving_start_is_where_it_was_put():
    x, v = state(oscillator(x0="-1", v0="-0.3"), Fraction(0))
    assert abs(x + 1) < TINY
    assert abs(v + Fraction("0.3")) < TINY


def test_default_energy_lost_is_that_of_the_chapter():
    assert Fraction("0.15") * (Fraction("1.7") + Fraction("1.1") + Fraction("0.5")) == Fraction(
        "0.495"
    )
    x, _ = state(oscillator(), Fraction(20))
    assert abs((1 - x**2) / 2 - Fraction("0.495")) < TINY


def test_without_friction_it_is_harmonic_and_never_stops():
    free = oscillator(friction_force="0", x0="0", v0="1")
    assert free.scalars() == {}
    x, v = state(free, Fraction(30))
    assert abs(x * x + v * v - 1) < TINY


@pytest.mark.parametrize("scale", [{"x": 1.0, "v": 1.0}, {"x": 0.1, "v": 3.0}])
@pytest.mark.parametrize("t", [Fraction(1), Fraction(3), Fraction(7), Fraction(12)])
def test_no_small_displacement_grows_beyond_the_sensitivity(scale, t):
    p = {name: Fraction(text) for name, text in DEFAULTS.items()}
    base = CoulombOscillator(refiner=Refiner.of(scale), **p)
    start = base.at(t)
    growth = dict.fromkeys(scale, 0.0)
    for axis, size in enumerate(scale.values()):
        moved = base.displaced(axis, Fraction(size) / 10**9).at(t)
        for name in scale:
            growth[name] += abs(float((moved[name].mid - start[name].mid) * 10**9)) / scale[name]
    assert max(growth.values()) <= base.sensitivity(t) * (1 + 1e-6)
    assert base.sensitivity(t) <= 1.5 * max(scale["x"] / scale["v"], scale["v"] / scale["x"])


def test_a_turning_point_exactly_on_the_boundary_cannot_be_decided_by_balls():
    undecided = oscillator(x0="-0.15", v0="0.3", friction_force="0.15")
    with pytest.raises(NotCertifiedError, match="cannot decide"):
        undecided.scalars()


def test_before_the_start_nothing_is_certified():
    with pytest.raises(NotCertifiedError, match="t < 0"):
        oscillator().at(Fraction(-1))
