"""Derivatives of a bounce and of an oscillator, by hand, and what the check `gradient` says of
them.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.checks.gradient import CHECK
from refdem.core import discovery
from refdem.core.problem import Request
from refdem.errors import NotCertifiedError
from refdem.faults.catalogue import chosen
from refdem.faults.transparent import Transparent
from refdem.kills.trials import FaultTrial
from refdem.planning.in_process import record_of, task_of, truth_of

ENGINE = Transparent()
BALL = {"height": "2", "gravity": "8", "restitution": "1/2", "bounces": "1", "samples": "16"}


def found(case, engine=ENGINE, levels=3, **given):
    """The findings of the check by quantity."""
    instance = discovery.case(case).at(**given)
    task = task_of(engine, "verlet-tangent", instance, truth_of(instance), levels, ["gradient"])
    return {finding.quantity: finding for finding in record_of(task).findings}


def derivatives(instance, *keys):
    """The derivatives of a run of the transparent engine by these numbers of the scene."""
    step = float(instance.times[1])
    request = Request(
        problem=instance.problem, method="verlet-tangent", step=step, sensitivities=keys
    )
    return ENGINE.run(request)[0]


def test_the_derivatives_of_a_bounce_are_those_of_its_formula():
    # y = h - g t^2/2 until t1 = sqrt(2 h/g); then y = e g t1 (t - t1) - g (t - t1)^2/2.
    h, g, e = 2.0, 8.0, 0.5
    instance = discovery.case("bouncing-ball").at(**BALL)
    keys = ("scene.bodies.0.position.1", "scene.elements.0.restitution", "scene.elements.2.g.1")
    run = derivatives(instance, *keys)
    t1 = np.sqrt(2 * h / g)
    after = run.t > t1
    s = run.t - t1
    by_height = np.where(after, e * g * s / (g * t1) - e + g * s / (g * t1), 1.0)
    by_restitution = np.where(after, g * t1 * s, 0.0)
    # dt1/dg = -t1/(2 g), and gravity is -g along y.
    late = t1 / (2 * g)
    by_g = np.where(
        after,
        e * t1 * s - e * g * late * s + e * g * t1 * late - s**2 / 2 - g * s * late,
        -(run.t**2) / 2,
    )
    assert after.any()
    assert not after.all()
    # The ball begins above the plane by h + R, and R stays: a lift of the start is one of h.
    np.testing.assert_allclose(run.derivatives[keys[0]][:, 0, 1], by_height, atol=1e-12)
    np.testing.assert_allclose(run.derivatives[keys[1]][:, 0, 1], by_restitution, atol=1e-12)
    np.testing.assert_allclose(run.derivatives[keys[2]][:, 0, 1], -by_g, atol=1e-12)


def test_an_even_turn_is_differentiated_by_omega_also_at_rest():
    # q = (cos(w t/2), 0, 0, sin(w t/2)): dq/dw = t/2 (-sin, 0, 0, cos).
    for spin in (0.0, 1.5):
        instance = discovery.case("bouncing-ball").at(**BALL, spin=str(spin))
        run = derivatives(instance, "scene.bodies.0.omega.2")
        half = spin * run.t / 2
        slopes = run.derivatives["scene.bodies.0.omega.2"][:, 0]
        np.testing.assert_allclose(slopes[:, 6], -run.t / 2 * np.sin(half), atol=1e-14)
        np.testing.assert_allclose(slopes[:, 9], run.t / 2 * np.cos(half), atol=1e-14)


@pytest.mark.parametrize(
    ("case", "given"),
    [
        ("harmonic-oscillator", {"v0": "1/2", "gravity": "1", "duration": "8", "samples": "32"}),
        ("bouncing-ball", BALL),
        ("hard-wall", {"samples": "16", "velocity": "3/4,-1,1/4", "normal": "1/8,1,1/4"}),
    ],
)
def test_right_derivatives_pass_through_smooth_motion_and_impacts(case, given):
    findings = found(case, **given)
    assert {name: finding.outcome for name, finding in findings.items()}.keys() >= {"matrix"}
    assert all(finding.outcome == "pass" for finding in findings.values())


def test_derivatives_of_a_smooth_motion_have_the_order_of_the_method():
    order = found("harmonic-oscillator", duration="8", samples="32")["order"]
    assert order.order_seen == pytest.approx(2.0, abs=0.05)
    assert order.order_claimed == 2.0


class OnePart(Transparent):
    """The transparent engine, which answers a thousandth too much in one column."""

    def run(self, request):
        """The run with one column of its derivatives changed."""
        trajectory, cost = super().run(request)
        key = "scene.elements.0.restitution"
        changed = trajectory.derivatives | {key: 1.001 * trajectory.derivatives[key]}
        return replace(trajectory, derivatives=changed), cost


def test_the_sentence_names_the_derivative_that_is_wrong():
    matrix = found("bouncing-ball", OnePart(), **BALL)["matrix"]
    assert matrix.outcome == "fail"
    assert "by restitution at" in matrix.sentence
    # In units of the largest derivative by the restitution, up to the samples of the last one.
    assert 1e-4 < matrix.value < 1.1e-3


class Unlocated(Transparent):
    """The transparent engine, which does not claim to locate events; what it tells of the
    restitution is wrong by `part`.
    """

    methods = tuple(
        replace(method, locates_events=False) if method.differentiates else method
        for method in Transparent.methods
    )
    part = 0.0

    def run(self, request):
        """The run with one column of its derivatives changed."""
        trajectory, cost = super().run(request)
        key = "scene.elements.0.restitution"
        changed = {**trajectory.derivatives}
        if key in changed:
            changed[key] = (1.0 + self.part) * changed[key]
        return replace(trajectory, derivatives=changed), cost


def test_a_method_that_locates_no_events_gets_the_claimed_bound_and_no_order():
    located = found("bouncing-ball", **BALL)["matrix"]
    unlocated = found("bouncing-ball", Unlocated(), **BALL)
    assert set(unlocated) == {"matrix"}
    assert unlocated["matrix"].outcome == "pass"
    # Halvings of the step tell nothing of it; with located events they show that this is exact.
    assert unlocated["matrix"].bound > 1e3 * located.bound


@pytest.mark.parametrize(("part", "outcome"), [(0.25, "pass"), (4.0, "fail")])
def test_that_bound_is_what_a_method_without_located_events_may_err_by(part, outcome):
    engine = Unlocated()
    engine.part = part * found("bouncing-ball", Unlocated(), **BALL)["matrix"].bound
    assert found("bouncing-ball", engine, **BALL)["matrix"].outcome == outcome


class Mute(Transparent):
    """The transparent engine, which claims to differentiate and does not."""

    def run(self, request):
        """The run without its derivatives."""
        trajectory, cost = super().run(request)
        return replace(trajectory, derivatives={}), cost


def test_a_run_without_what_was_asked_for_fails():
    matrix = found("bouncing-ball", Mute(), levels=1, **BALL)["matrix"]
    assert matrix.outcome == "fail"
    assert matrix.sentence == (
        "The run has no derivatives by scene.bodies.0.mass, which the request asked for."
    )


def test_derivatives_that_are_not_certified_decide_nothing():
    instance = discovery.case("bouncing-ball").at(**BALL)
    truth = truth_of(instance)

    def refuses(subject, times):
        raise NotCertifiedError("no derivative here")

    task = task_of(ENGINE, "verlet-tangent", instance, truth, 1, ["gradient"])
    subject = replace(task.subject, derivatives=refuses)
    (finding,) = CHECK.judge(subject, {})
    assert (finding.quantity, finding.outcome) == ("matrix", "undecided")
    assert finding.sentence == "Undecided: no derivative here."


def test_methods_that_do_not_differentiate_are_left_out():
    instance = discovery.case("bouncing-ball").at(**BALL)
    task = task_of(ENGINE, "verlet", instance, truth_of(instance), 1)
    assert task.left_out["gradient"] == "the method does not differentiate"


@pytest.mark.parametrize("fault", chosen(["gradient"]), ids=lambda fault: fault.name)
def test_each_wrong_derivative_is_seen_by_the_check(fault):
    kill = FaultTrial(seeds=1, chosen=(fault,), whole=False).kill(fault, 1)
    assert kill.killed, kill.sentence
