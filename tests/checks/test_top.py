"""The check of a top on its tip passes the true motion and is failed, in the quantity that is
wrong, by small faults.
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
from refdem.scene import Body
from refdem.scene.elements.ball_joint import BallJoint
from tests.handmade import U, findings, instance, method, near, standing

CHECK = discovery.check("top")
METHOD = ENGINE.method("spinning-top")
TRIAL = Subject(
    discovery.case("heavy-top").at(phidot0="2", thetadot0="-1"),
    replace(METHOD, derived={}),
    (0.0,),
    None,
)
"""As if places were not made of the attitude, so that the joint can be open."""


def outcomes(spoil=lambda run: run):
    """Findings of the reference's run, spoiled, by quantity."""
    run, _ = ENGINE.run(Request(problem=TRIAL.instance.problem, method="spinning-top"))
    assert CHECK.applies(TRIAL) is None
    return {
        f.quantity: f.outcome
        for f in CHECK.judge(TRIAL, {Variant(0.0): CompletedRun(spoil(run), Cost(seconds=0.0))})
    }


def scaled(column, factor):
    def spoil(run):
        values = np.array(getattr(run, column))
        values[16:] *= factor
        return replace(run, **{column: values})

    return spoil


def tilted(run):
    """A torque about a horizontal axis alone: L_z stays, the axis of the top does not carry L_3 as
    it should.
    """
    omega = np.array(run.omega)
    omega[16:, :, 0] += 1e-9
    return replace(run, omega=omega)


def test_the_true_motion_passes():
    assert outcomes() == {"joint": "pass", "joint velocity": "pass", "L_z": "pass", "L_3": "pass"}


@pytest.mark.parametrize(
    ("spoil", "quantity"),
    [
        (scaled("position", 1 + 1e-9), "joint"),
        (scaled("velocity", 1 + 1e-9), "joint velocity"),
        (scaled("omega", 1 + 1e-9), "L_z"),
        (tilted, "L_3"),
    ],
)
def test_it_is_failed_in_the_quantity_that_is_wrong(spoil, quantity):
    assert outcomes(spoil)[quantity] == "fail"


def test_a_joint_that_is_closed_by_construction_is_not_judged():
    run, _ = ENGINE.run(Request(problem=TRIAL.instance.problem, method="spinning-top"))
    found = CHECK.judge(
        replace(TRIAL, method=METHOD), {Variant(0.0): CompletedRun(run, Cost(seconds=0.0))}
    )
    assert {f.quantity for f in found} == {"L_z", "L_3"}


def test_without_a_ball_joint_it_does_not_apply():
    instance = discovery.case("pendulum").at()
    assert (
        CHECK.applies(Subject(instance, ENGINE.method("rattle"), (0.1,), None))
        == "the scene has no top"
    )


def test_the_terms_of_a_momentum_are_rounded_and_not_their_sum():
    # J omega = (6 3, 0, 1 4) and m arm x v = 2 (0, 0, 1) x (0, -3, 0) = (6, 0, 0): L_z = L_3 = 4.
    # L_z has terms of 6 5 + 2 1 3 = 36, which is 9 of the scale 4, and L_3 of 1 5.
    body = Body(
        mass=2.0,
        inertia=(6.0, 6.0, 1.0),
        position=(0.0, 0.0, 1.0),
        velocity=(0.0, -3.0, 0.0),
        omega=(3.0, 0.0, 4.0),
    )
    of = instance([body], (BallJoint(a=0, b=-1, anchor_a=(0.0, 0.0, -1.0)),))
    exact = method("exact", conserves=frozenset({"angular-momentum"}), derived={"ball_joint": ""})
    found = findings(CHECK, Subject(of, exact, (0.0,), None), standing(of))
    assert found.keys() == {"L_z", "L_3"}
    round_off = 8 * U * 16
    assert found["L_z"].bound == near(9 * round_off, rel=1e-14)
    # Of L_3 no method claims more than its order, and an exact one has no truncation error.
    assert found["L_3"].bound == near(round_off * 5 / 4, rel=1e-14)
    assert (found["L_z"].value, found["L_3"].value) == (0.0, 0.0)
