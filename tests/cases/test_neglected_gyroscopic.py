"""The right motion matches in both members, and the run without the gyroscopic term is flagged in
both.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from refdem.faults.catalogue import chosen
from refdem.faults.transparent import Transparent
from refdem.planning.in_process import record_of, task_of, truth_of

CASE = discovery.case("neglected-gyroscopic")
FREE = CASE.at(duration="0.1", samples="8")
FALLING = CASE.at(member="slope", duration="1/16", samples="4", stiffness="2e3")
"""It falls and does not touch yet: cheap to certify, and soft, so that steps may be long."""


def wrong():
    return chosen(["no-gyroscopic-term"])[0].carrier()


def flagged(engine, instance, method):
    record = record_of(task_of(engine, method, instance, truth_of(instance), 3))
    return [f"{f.check}/{f.quantity}" for f in record.findings if f.outcome in ("fail", "error")]


@pytest.mark.parametrize("instance", [FREE, FALLING], ids=["free", "slope"])
def test_the_right_run_matches_and_the_counterexample_is_flagged(instance):
    assert flagged(Transparent(), instance, "verlet") == []
    found = flagged(wrong(), instance, "verlet")
    assert {"error/omega.x", "error/attitude", "error/omega_body.y"} <= set(found)


@pytest.mark.parametrize("member", ["free", "slope"])
def test_the_reference_matches(member):
    if member == "free":
        instance = FREE
    else:
        instance = FALLING
    for method in ENGINE.methods:
        if method.control == "exact" and ENGINE.unsupported(instance.problem, method) is None:
            assert flagged(ENGINE, instance, method.name) == []
            return
    pytest.fail("no exact method")


def test_through_three_contacts_the_right_motion_converges_and_the_counterexample_does_not():
    instance = CASE.at(member="slope", duration="0.15", samples="16")
    right, _ = ENGINE.run(Request(problem=instance.problem, method="tumbling-body"))
    assert sum(event.kind == "contact" for event in right.events) == 3

    def away(engine, part):
        run, _ = engine.run(
            Request(
                problem=instance.problem, method="verlet", step=instance.problem.interval / part
            )
        )
        return np.abs(run.omega - right.omega).max() / 54.4

    assert away(Transparent(), 256) < away(Transparent(), 64) / 4
    assert away(Transparent(), 256) < 1e-3
    assert away(wrong(), 256) > 1.0


def test_the_box_has_the_moments_of_its_sides():
    (body,) = CASE.at(member="slope").scene.bodies.single()
    x, y, z = (2 * abs(value) for value in body.shape.vertices[0])
    assert (x, y, z) == pytest.approx((0.06, 0.04, 0.02), rel=1e-14)
    assert body.inertia == pytest.approx(
        tuple(0.01 * s for s in (y * y + z * z, z * z + x * x, x * x + y * y)), rel=1e-14
    )


def test_the_start_is_that_of_the_figure():
    (body,) = CASE.at().scene.bodies.single()
    assert body.omega == pytest.approx((10 * np.pi,) * 3, rel=1e-15)
    assert body.velocity == (0.0, 0.0, 0.025)
    assert CASE.at().p["omega_body"] == (Fraction("31.41592653589793"),) * 3
    assert CASE.at().times[-1] == pytest.approx(0.6, rel=1e-5)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"inertia": "1,2,3"}, "that of a box"),
        ({"height": "0.03"}, "above the slope"),
        ({"omega_body": "0,0,0"}, "a body that spins"),
        ({"inertia": "1,1,4"}, "triangle inequality"),
    ],
)
def test_what_does_not_go_together_is_refused(given, said):
    with pytest.raises(UsageError, match=said):
        CASE.at(member="slope", **given)
