"""The check of a capture counts the turns that a coarse sampling hides, and still sees a hook that
brakes what it catches.
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
from refdem.planning.in_process import truth_of

CHECK = discovery.check("capture")


def outcomes(samples, *, turned=1.0, slowed=1.0):
    """Findings of the reference's run over 40 s, its places turned about the hook or its speed
    slowed after the catch.
    """
    instance = discovery.case("captured-mass").at(
        duration="40", samples=samples, speed="3", radius="3"
    )
    subject = Subject(instance, ENGINE.method("exact-capture"), (0.0,), truth_of(instance))
    run, _ = ENGINE.run(Request(problem=instance.problem, method="exact-capture"))
    later = (run.t > 3.0).nonzero()[0]
    angle = (turned - 1) * run.t[later]
    c = np.cos(angle)[:, None, None]
    s = np.sin(angle)[:, None, None]
    position = np.array(run.position)
    velocity = np.array(run.velocity)
    for column in (position, velocity):
        x = column[later, :, 0:1]
        y = column[later, :, 1:2]
        column[later, :, 0:1] = c * x - s * y
        column[later, :, 1:2] = s * x + c * y
    velocity[later] *= slowed
    spoiled = replace(run, position=position, velocity=velocity)
    findings = CHECK.judge(subject, {Variant(0.0): CompletedRun(spoiled, Cost(seconds=0.0))})
    return {f.quantity: f.outcome for f in findings}


@pytest.mark.parametrize("samples", ["7", "12", "13", "40", "400"])
def test_the_true_motion_passes_however_coarsely_it_is_sampled(samples):
    assert outcomes(samples) == dict.fromkeys(("omega", "speed", "inertia"), "pass")


@pytest.mark.parametrize("samples", ["7", "13", "400"])
def test_a_turning_too_fast_by_a_billionth_is_seen(samples):
    assert set(outcomes(samples, turned=1 + 1e-9).values()) == {"fail"}


def test_a_speed_that_does_not_belong_to_the_turning_is_seen():
    assert outcomes("400", slowed=1 - 1e-9) == {"omega": "pass", "speed": "fail", "inertia": "fail"}
