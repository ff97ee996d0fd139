"""Derivatives of a bounce and of an oscillator, by hand, and what the check `gradient` says of
them.
"""

import json
from dataclasses import replace

import numpy as np
import pytest

from refdem.checks.gradient import CHECK
from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.scene_numbers import numbers_in
from refdem.errors import NotCertifiedError
from refdem.faults.catalogue import chosen
from refdem.faults.transparent import Transparent
from refdem.kills.trials import FaultTrial
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene import Scene

ENGINE = Transparent()
BALL = {"height": "2", "gravity": "8", "restitution": "1/2", "bounces": "1", "samples": "16"}


def found(case, engine=ENGINE, levels=3, method="verlet-tangent", **given):
    """The findings of the check by quantity."""
    instance = discovery.case(case).at(**given)
    task = task_of(engine, method, instance, truth_of(instance), levels, ["gradient"])
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


SHORT = {"gravity": "9.81", "bounces": "40", "duration": "3.853e-05", "samples": "16"}
"""Gravity moves the ball by a thousandth of its fall."""
HIGH = {
    "radius": "0.0675",
    "velocity": "0.7,-25.1",
    "gravity": "3.87",
    "duration": "7.011",
    "samples": "16",
}
"""The radius is small beside the height that the ball reaches."""


@pytest.mark.parametrize(
    ("case", "given"),
    [
        ("bouncing-ball", SHORT),
        ("bouncing-ball", HIGH),
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


class ByDifferences(Transparent):
    """The transparent engine, with derivatives by central differences of its runs: each number is
    moved by 1e-5 of itself. `factor` misreads those by `wrong`; `base` runs in its place.
    """

    def __init__(self, wrong="", factor=1.0, base=ENGINE):
        super().__init__()
        self.wrong = wrong
        self.factor = factor
        self.base = base
        self.methods = tuple(replace(method, differentiates=True) for method in base.methods)

    def unsupported_motion(self, problem, method):
        """What the method itself refuses."""
        return self.base.unsupported_motion(problem, self.base.method(method.name))

    def run(self, request):
        """The run, and the differences of two beside it for every number."""
        trajectory, cost = self.base.run(replace(request, sensitivities=()))
        derivatives = {}
        for key in request.sensitivities:
            derivatives[key] = self.difference(request, key)
            if key == self.wrong:
                derivatives[key] *= self.factor
        return replace(trajectory, derivatives=derivatives), cost

    def difference(self, request, key):
        """The central difference of the states by one number."""
        step = 1e-5 * (abs(numbers_in(request.problem.scene)[key]) or 1.0)
        above = states_at(self.base, request, key, step)
        below = states_at(self.base, request, key, -step)
        return (above - below) / (2 * step)


def states_at(engine, request, key, change):
    """The states of a run of an engine with one number of the scene changed."""
    document = json.loads(request.problem.scene.to_json())
    *way, last = key.split(".")[1:]
    place = document
    for name in way:
        place = place[int(name) if isinstance(place, list) else name]
    last = int(last) if isinstance(place, list) else last
    place[last] += change
    problem = replace(request.problem, scene=Scene.from_json(json.dumps(document)))
    run, _ = engine.run(replace(request, problem=problem, sensitivities=()))
    return np.concatenate([run.position, run.velocity, run.attitude, run.omega], axis=-1)


FAINT = {"mu": "0.000278", "p": "0.0559", "drive": "39.1", "x0": "0.358", "duration": "0.02558"}
"""Numbers that are hardly felt in so short a time."""
WEDGE = {"k1": "8.36", "k2": "18.8", "duration": "0.3459"}
"""The velocity errs by more of its small derivative by the mass than of its own scale."""
FALL = {"height": "1", "gravity": "8", "duration": "2", "samples": "17"}
"""A sample lies on the impact, and the method makes no error between impacts."""


@pytest.mark.parametrize(
    ("case", "method", "given"),
    [
        ("van-der-pol", "rk4", {"samples": "16", **FAINT}),
        ("wedge-collision", "verlet", {"samples": "16", **WEDGE}),
        ("bouncing-ball", "verlet", FALL),
        ("duffing", "rk4", {"duration": "4", "samples": "16"}),
    ],
)
def test_right_central_differences_pass(case, method, given):
    findings = found(case, ByDifferences(), method=method, **given)
    assert findings["matrix"].outcome == "pass", findings["matrix"].sentence
    assert all(finding.outcome == "pass" for finding in findings.values())


@pytest.mark.parametrize("factor", [0.99, 1.01, -1.0])
def test_central_differences_that_are_misread_fail(factor):
    engine = ByDifferences("scene.elements.0.stiffness", factor)
    given = {"gravity": "1", "duration": "4", "samples": "16"}
    assert found("harmonic-oscillator", ByDifferences(), method="rk4", **given)
    matrix = found("harmonic-oscillator", engine, method="rk4", **given)["matrix"]
    assert matrix.outcome == "fail"
    assert "by stiffness at" in matrix.sentence


@pytest.mark.parametrize("factor", [1.0, 1.05])
@pytest.mark.parametrize(
    ("case", "method", "given"),
    [
        ("two-spheres", "velocity-verlet", {}),
        ("two-spheres", "rk4", {}),
        ("two-spheres", "rk4", {"stiffness": "3000"}),
    ],
)
def test_steps_across_a_kink_lose_an_order_in_derivatives(case, method, given, factor):
    base = discovery.engine("reference")
    engine = ByDifferences("scene.bodies.0.velocity.0", factor, base)
    findings = found(case, engine, method=method, samples="16", **given)
    assert findings["matrix"].outcome == ("pass" if factor == 1.0 else "fail")


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


class Huge(Transparent):
    """The transparent engine, which answers with the largest numbers."""

    def run(self, request):
        """The run with derivatives whose sum overflows."""
        trajectory, cost = super().run(request)
        huge = {
            key: np.full_like(slopes, 1.7e308) for key, slopes in trajectory.derivatives.items()
        }
        return replace(trajectory, derivatives=huge), cost


def test_derivatives_that_overflow_fail():
    matrix = found("bouncing-ball", Huge(), levels=1, **BALL)["matrix"]
    assert matrix.outcome == "fail"
    assert matrix.sentence.startswith(
        "The run has a derivative by scene.bodies.0.mass of size 1.7e+308; expected at most 1e+250"
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
