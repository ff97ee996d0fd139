"""The limit of small steps: constants and clocks wrong by less than truncation are seen, correct
methods of any order are not accused.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.checks.limit import signed
from refdem.core import discovery
from refdem.core.judgement import PREDICTION_FACTOR
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.faults.change import of_elements, scaled
from refdem.faults.fault import Fault
from refdem.faults.transparent import Transparent
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.spring import Spring

OSCILLATOR = (
    "harmonic-oscillator",
    {
        "mass": "2",
        "stiffness": "3",
        "gravity": "5/4",
        "v0": "1/2",
        "duration": "8",
        "samples": "32",
    },
)
ORBIT = ("two-body-orbit", {"eccentricity": "1/4", "duration": "6", "samples": "32"})
BODY = ("free-rigid-body", {"omega_body": "1/2,-1,5/4", "duration": "6", "samples": "32"})


def found(engine, method, setting, levels=4):
    """What the check says of one method, as findings."""
    case, given = setting
    instance = discovery.case(case).at(**given)
    record = record_of(task_of(engine, method, instance, truth_of(instance), levels, ("limit",)))
    return [finding for finding in record.findings if finding.check == "limit"]


@pytest.mark.parametrize("setting", [OSCILLATOR, ORBIT, BODY], ids=["oscillator", "orbit", "body"])
@pytest.mark.parametrize(
    ("method", "order", "falls"),
    [("euler", 1, 2), ("verlet", 2, 4), ("rk4", 4, 5), ("suzuki", 4, 6)],
)
def test_what_is_left_of_a_correct_method_is_the_share_of_its_fall_that_its_next_order_says(
    setting, method, order, falls
):
    (finding,) = found(Transparent(), method, setting)
    assert finding.outcome == "pass"
    # The bound is PREDICTION_FACTOR times what the next order leaves of the last change.
    allowed = min(1.0, PREDICTION_FACTOR / (2 ** (order + 1) - 1))
    if finding.value > 1e-11:  # above round-off
        left = finding.value / finding.bound * allowed
        assert left == pytest.approx(1 / (2**falls - 1), rel=0.3)


@pytest.mark.parametrize(
    ("method", "setting"),
    [("velocity-verlet", OSCILLATOR), ("rk4", OSCILLATOR), ("rk4", ORBIT), ("rk4-free-body", BODY)],
)
def test_the_reference_holds(method, setting):
    assert [finding.outcome for finding in found(ENGINE, method, setting)] == ["pass"]


SPRING = of_elements(Spring, stiffness=scaled(1 + 1e-7))
FINE_SPRING = of_elements(Spring, stiffness=scaled(1 + 1e-8))
FIELD = of_elements(CentralField, gm=scaled(1 + 1e-7))


@pytest.mark.parametrize(
    ("method", "setting", "before"),
    [
        ("velocity-verlet", OSCILLATOR, SPRING),
        ("rk4", OSCILLATOR, SPRING),
        ("rk4", OSCILLATOR, FINE_SPRING),
        ("velocity-verlet", ORBIT, FIELD),
    ],
)
def test_a_constant_that_is_wrong_by_one_part_in_ten_million_is_seen(method, setting, before):
    hair = Fault(
        name="hair",
        kind="units",
        sentence="",
        on=("oscillator",),
        sees=("limit", "state"),
        before=before,
    )
    (finding,) = found(hair.carrier(ENGINE), method, setting)
    assert finding.outcome == "fail"
    assert finding.value < 1e-4  # less than the truncation error at the steps themselves
    assert "extrapolated" in finding.sentence


def test_errors_that_do_not_fall_with_the_claimed_order_decide_nothing_here():
    second = Fault(
        name="second-order",
        kind="integrator",
        sentence="",
        on=("oscillator",),
        sees=("order", "state"),
        inside=lambda p: {"suzuki": (0.25, 0.25, 0.25, 0.25)},
    )
    (finding,) = found(second.carrier(), "suzuki", OSCILLATOR)
    assert finding.outcome == "undecided"
    assert "do not yet fall with order 4" in finding.sentence


@pytest.mark.parametrize(
    ("case", "given", "method"),
    [
        ("two-spheres", {"damping": "1"}, "velocity-verlet"),
        ("harmonic-oscillator", {"duration": "8"}, "exact-harmonic"),
    ],
)
def test_it_does_not_apply_to_kinks_nor_without_a_step(case, given, method):
    assert found(ENGINE, method, (case, given)) == []


def test_two_levels_are_too_few():
    assert found(ENGINE, "velocity-verlet", OSCILLATOR, levels=2) == []


def test_differences_from_truth_are_in_units_of_the_scale_of_each_quantity():
    instance = discovery.case("harmonic-oscillator").at(x0="8", v0="1/2")
    task = task_of(ENGINE, "exact-harmonic", instance, truth_of(instance), 1, ())
    run, _ = ENGINE.run(Request(problem=instance.problem, method="exact-harmonic"))
    moved = replace(run, position=run.position + 0.25)
    names = list(instance.quantities)
    scale = instance.quantities["x"].scale
    assert scale != 1.0
    off = signed(task.subject, moved, task.subject.truth, len(run.t))[names.index("x")]
    assert off == pytest.approx(np.full(len(run.t), 0.25 / scale), abs=1e-12)
