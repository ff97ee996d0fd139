"""The second integral of the swinging machine: passed by the true motion for any small wheel,
failed by faults of the string's motion.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.problem import Request
from refdem.core.trajectory import Cost
from refdem.core.variant import Variant
from refdem.engines.reference import ENGINE
from refdem.truth.sampled import sampled

CHECK = discovery.check("second-integral")
GIVEN = {"wheel_inertia": "0", "counter_mass": "3", "duration": "2", "samples": "16"}


@pytest.fixture(scope="module", params=["0", "1/50"])
def subject(request):
    """The subject of the reference at a radius of the wheel."""
    instance = discovery.case("pendulum-wheel-mass").at(wheel_radius=request.param, **GIVEN)
    truth = sampled(instance.truth(), instance.times.tolist())
    return Subject(instance, ENGINE.method("string-wheel"), (0.0,), truth)


def finding(subject, spoil=lambda run: run):
    """What the check finds in the reference's run, spoiled."""
    run, _ = ENGINE.run(Request(problem=subject.instance.problem, method="string-wheel"))
    assert CHECK.applies(subject) is None
    (found,) = CHECK.judge(subject, {Variant(0.0): CompletedRun(spoil(run), Cost(seconds=0.0))})
    return found


def test_the_true_motion_passes_and_the_drift_of_the_radius_is_told(subject):
    found = finding(subject)
    assert found.outcome == "pass"
    drift = float(found.basis.split("drifts by ")[1].rstrip(")"))
    assert (drift > 1e-3) is (subject.instance.p.wheel_radius > 0)
    assert drift < (0.2 if subject.instance.p.wheel_radius > 0 else 1e-14)


@pytest.mark.parametrize(("column", "factor"), [("velocity", 1 + 1e-9), ("position", 1 - 1e-9)])
def test_a_string_that_slips_or_stretches_by_a_hair_fails(subject, column, factor):
    def spoil(run):
        values = np.array(getattr(run, column))
        values[8:] *= factor
        return replace(run, **{column: values})

    assert finding(subject, spoil).outcome == "fail"


def test_the_drift_of_another_radius_fails(subject):
    """A wheel that is left out, or put in: the motion of a machine with another radius keeps, or
    loses, what it should not.
    """
    if subject.instance.p.wheel_radius > 0:
        other = "0"
    else:
        other = "1/1000000"
    instance = discovery.case("pendulum-wheel-mass").at(wheel_radius=other, **GIVEN)
    run, _ = ENGINE.run(Request(problem=instance.problem, method="string-wheel"))
    (found,) = CHECK.judge(subject, {Variant(0.0): CompletedRun(run, Cost(seconds=0.0))})
    assert found.outcome == "fail"


@pytest.mark.parametrize(
    "given", [{}, {"counter_mass": "3"}, {"counter_mass": "5/2", "wheel_inertia": "0"}]
)
def test_where_there_is_no_second_integral_the_check_does_not_apply(given):
    instance = discovery.case("pendulum-wheel-mass").at(**given)
    assert (
        CHECK.applies(Subject(instance, ENGINE.method("string-wheel"), (0.0,), None))
        == "the machine has no second integral"
    )


def test_the_drift_that_is_told_is_a_part_of_the_integral_whatever_the_units():
    """Four times the gravity is the same motion in half the time: the terms of the integral grow
    fourfold, and the drift with them.
    """

    def told(**more):
        instance = discovery.case("pendulum-wheel-mass").at(
            **(GIVEN | {"wheel_radius": "1/50"} | more)
        )
        truth = sampled(instance.truth(), instance.times.tolist())
        return (
            finding(Subject(instance, ENGINE.method("string-wheel"), (0.0,), truth))
            .basis.split("drifts by ")[1]
            .split(":")[0]
        )

    gravity = float(discovery.case("pendulum-wheel-mass").at().p.gravity)
    assert told() == told(gravity=str(4 * gravity), duration="1")
