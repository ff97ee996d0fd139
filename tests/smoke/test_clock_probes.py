"""Clocks of programs: those that count are right, and every one that compares or divides times is
caught, and told what to do.
"""

import math
from itertools import pairwise

import numpy as np
import pytest

from refdem.core.engine import Engine, Method
from refdem.core.trajectory import Cost, Trajectory
from refdem.smoke.clock import QUANTITY, step_count_findings

DRIFT = Method(name="drift", summary="free flight", control="step", order=1, backward=True)


def by_stride(times, h, stride, number):
    return [stride * n for n in range(len(times))]


def rounding(times, h, stride, number):
    return [round(abs(t - times[0]) / abs(h)) for t in times]


def half_a_step_early(times, h, stride, number):
    return summed(times, h, lambda ahead, step: ahead > step / 2, number)


def while_before(times, h, stride, number):
    return summed(times, h, lambda ahead, step: ahead > 0, number)


def while_a_step_fits(times, h, stride, number):
    return summed(times, h, lambda ahead, step: number(ahead - step) >= 0, number)


def truncated(times, h, stride, number):
    taken = [int(abs(number(after - before)) / abs(h)) for before, after in pairwise(times)]
    return np.cumsum([0, *taken]).tolist()


def rounded_up(times, h, stride, number):
    taken = [math.ceil(abs(number(after - before)) / abs(h)) for before, after in pairwise(times)]
    return np.cumsum([0, *taken]).tolist()


def truncated_from_the_start(times, h, stride, number):
    return [int(abs(number(t - times[0])) / abs(h)) for t in times]


def multiplied(times, h, stride, number):
    taken = []
    count = 0
    for sample in times:
        while (sample - number(times[0] + number(number(count) * h))) * np.sign(h) > 0:
            count += 1
        taken.append(count)
    return taken


def a_step_short(times, h, stride, number):
    return [(stride - 1) * n for n in range(len(times))]


def a_sample_late(times, h, stride, number):
    return [stride * max(0, n - 1) for n in range(len(times))]


def summed(times, h, goes_on, number):
    """Steps taken at each sample by a clock that adds its steps up while `goes_on(ahead, step)`."""
    clock = times[0]
    count = 0
    taken = []
    for sample in times:
        while goes_on(number((sample - clock) * np.sign(h)), abs(h)):
            clock = number(clock + h)
            count += 1
        taken.append(count)
    return taken


class Flight(Engine):
    """Free points moved by counted steps; the clock that counts them is given."""

    name = "flight"
    title = "Flight"

    def __init__(self, clock, number=np.float64, method=DRIFT, pace=1.0):
        self.clock = clock
        self.number = number
        self.pace = pace
        self.methods = (method,)

    def missing(self):
        return None

    def version(self):
        return "1"

    def fingerprint(self, method):
        return "flight"

    def unsupported_motion(self, problem, method):
        if problem.scene.elements:
            return "no elements"
        return None

    def run(self, request):
        bodies = request.problem.scene.bodies
        times = [self.number(t) for t in request.problem.times]
        taken = self.clock(times, self.number(request.signed_step), request.stride, self.number)
        passed = np.array(taken) * request.signed_step
        velocity = np.tile(self.pace * bodies.velocity, (len(times), 1, 1))
        position = bodies.position + passed[:, None, None] * velocity
        return Trajectory.of_points(request.problem.times, position, velocity), Cost(seconds=0.0)


RIGHT = (by_stride, rounding, half_a_step_early)
WRONG = (
    while_before,
    while_a_step_fits,
    truncated,
    rounded_up,
    truncated_from_the_start,
    multiplied,
    a_step_short,
    a_sample_late,
)


def found(engine):
    (finding,) = step_count_findings(engine, engine.methods[0])
    assert finding.quantity == QUANTITY
    return finding


@pytest.mark.parametrize("clock", RIGHT)
def test_a_program_that_counts_its_steps_is_right(clock):
    finding = found(Flight(clock))
    assert (finding.outcome, finding.value < 1e-9) == ("pass", True)


@pytest.mark.parametrize("wrong_way", ["forwards", "backwards"])
@pytest.mark.parametrize("clock", WRONG)
def test_a_clock_that_compares_or_divides_times_is_caught_and_told_what_to_do(clock, wrong_way):
    def one_way(times, h, stride, number):
        goes_wrong = (h > 0) == (wrong_way == "forwards")
        return (clock if goes_wrong else by_stride)(times, h, stride, number)

    finding = found(Flight(one_way))
    assert finding.outcome == "fail"
    assert (
        "count `stride` steps from each sample to the next and never compare times"
        in finding.sentence
    )


@pytest.mark.parametrize("clock", [while_before, while_a_step_fits])
def test_a_summed_clock_in_single_precision_is_caught(clock):
    assert found(Flight(clock, np.float32)).outcome == "fail"


def test_the_sentence_says_how_many_steps_are_too_many():
    assert "has taken 1 step too many at sample" in found(Flight(while_before)).sentence
    assert "one sample late" in found(Flight(a_sample_late)).sentence


def test_a_wrong_unit_is_not_blamed_on_the_clock():
    assert found(Flight(by_stride, pace=1000.0)).outcome == "pass"
    assert found(Flight(while_before, pace=1000.0)).outcome == "fail"


def test_a_program_that_never_steps_backwards_has_taken_too_few():
    def only_forwards(times, h, stride, number):
        if h > 0:
            return by_stride(times, h, stride, number)
        return [0] * len(times)

    assert "too few" in found(Flight(only_forwards)).sentence


def test_a_method_without_steps_has_no_clock_to_look_at():
    assert (
        step_count_findings(
            Flight(by_stride), Method(name="drift", summary="", control="tolerance")
        )
        == []
    )


def test_what_an_adapter_raises_is_an_error_of_its_clock():
    def raises(*_):
        raise ZeroDivisionError("no step")

    finding = found(Flight(raises))
    assert finding.outcome == "error"
    assert "ZeroDivisionError: no step" in finding.sentence
