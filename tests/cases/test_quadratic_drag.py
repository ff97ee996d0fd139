"""Quadratic drag: what it refuses, its limits, its truth against impulses and other numbers."""

import math
from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from refdem.scene.elements.drag import Drag

CASE = discovery.case("quadratic-drag")
FAST = {"v0": "-20"}
THROWN = {"v0": "3"}


def values(truth, t):
    return {name: float(ball.mid) for name, ball in truth.at(Fraction(t)).items()}


@pytest.mark.parametrize("name", ["mass", "gravity", "drag"])
@pytest.mark.parametrize("value", ["0", "-1"])
def test_numbers_that_are_no_fall_are_refused_by_name(name, value):
    with pytest.raises(UsageError, match=name):
        CASE.at(**{name: value})


@pytest.mark.parametrize("given", [{}, THROWN, FAST, {"v0": "-8"}, {"v0": "100"}])
def test_the_velocity_tends_to_the_one_at_which_drag_bears_the_weight(given):
    truth = CASE.at(**given).truth()
    assert values(truth, 40)["v"] == pytest.approx(-math.sqrt(2 * 8 / 0.25), rel=1e-12)


def test_a_body_that_is_thrown_up_rises_to_the_known_height_and_comes_back_slower():
    """v^2 + v_t^2 falls as exp(-2 y/L) on the way up: top = L/2 ln(1 + v0^2/v_t^2)."""
    truth = CASE.at(**THROWN).truth()
    top = float(truth.scalars()["top"].mid)
    assert top == pytest.approx(4 * math.log1p(9 / 64), rel=1e-14)
    time_up = float(truth.scalars()["top_time"].mid)
    assert abs(values(truth, Fraction(time_up))["v"]) < 1e-14 * 8
    # Back at the start: 1/v^2 = 1/v0^2 + 1/v_t^2.
    back = 1 / math.sqrt(1 / 9 + 1 / 64)
    low, high = time_up, 2.0
    for _ in range(60):
        middle = (low + high) / 2
        if values(truth, Fraction(middle))["y"] > 0:
            low = middle
        else:
            high = middle
    assert values(truth, Fraction(low))["v"] == pytest.approx(-back, rel=1e-12)


def test_at_the_terminal_velocity_the_body_falls_evenly():
    truth = CASE.at(v0="-8").truth()
    assert truth.at(Fraction(3))["y"].mid == pytest.approx(-24, abs=1e-30)


def displaced(given, error, made_at, t):
    """The state (y, v) at t in scales, an impulse of the velocity having acted at `made_at`."""
    instance = CASE.at(**given)
    scale = [quantity.scale for quantity in instance.quantities.values()]
    before = values(instance.truth(), made_at)
    start = Fraction(before["v"]) + Fraction(error * scale[1])
    again = CASE.at(**(given | {"v0": str(start)})).truth()
    after = values(again, t - made_at)
    return np.array([before["y"] + after["y"], after["v"]]) / scale


@pytest.mark.parametrize("given", [{}, THROWN, FAST, {"v0": "-9"}, {"v0": "-7"}, {"v0": "60"}])
def test_the_largest_growth_of_impulses_at_any_time_is_that_of_s(given):
    """An error of the velocity moves the place; one of the place stays what it is."""
    truth = CASE.at(**given).truth()
    for t in (Fraction(1, 8), Fraction(1), Fraction(4)):
        error = 1e-6
        growths = []
        for part in range(33):
            made_at = t * part / 33
            change = displaced(given, error, made_at, t) - displaced(given, 0.0, made_at, t)
            growths.append(1 + abs(change[0]) / error)
        bound = truth.sensitivity(t)
        # 1e-4: differences over 1e-6 of numbers with 16 digits, and their second order.
        assert max(growths) <= bound * (1 + 1e-4)
        assert max(growths) >= 0.99 * bound


@pytest.mark.parametrize("given", [{}, THROWN, FAST, {"v0": "-8"}, {"v0": "300"}])
@pytest.mark.parametrize("duration", ["1/1000", "5", "400"])
def test_the_solver_meets_the_truth_at_short_and_at_long_times(given, duration):
    instance = CASE.at(**given, duration=duration, samples="16")
    run, _ = ENGINE.run(Request(problem=instance.problem, method="exact-drag"))
    truth = instance.truth()
    for index, t in enumerate(instance.times):
        exact = values(truth, Fraction(float(t)))
        y, v = run.position[index, 0, 1], run.velocity[index, 0, 1]
        assert y == pytest.approx(exact["y"], rel=2e-14, abs=1e-14 * instance.scales.length)
        assert v == pytest.approx(exact["v"], rel=2e-14, abs=1e-14 * instance.scales.speed)


def test_methods_that_do_not_know_the_drag_refuse_it():
    problem = CASE.at().problem
    answering = {m.name for m in ENGINE.methods if ENGINE.unsupported(problem, m) is None}
    assert answering == {"exact-drag"}


def test_a_drag_that_pushes_is_refused():
    assert Drag(a=0, coefficient=-1.0).faults() == ["coefficient is -1.0, expected >= 0"]
