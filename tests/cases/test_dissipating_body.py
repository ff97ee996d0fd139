"""A body that loses energy inside: L stays, energy falls to L^2/(2 J3), and signs and factors that
are wrong are seen.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene.elements.internal_damping import InternalDamping
from refdem.truth.witnesses.cross_check import witnesses

SETS = [
    {},
    {"inertia": "2,2,3", "damping": "1"},
    {"inertia": "3,1,2", "omega_body": "1/10,2,-1/10", "attitude": "1,2,3,4"},
    {"damping": "0"},
]
REFERENCE = discovery.engine("reference")


def failures(**given):
    """Quantities of the reference that fail, and how many were decided."""
    instance = discovery.case("dissipating-body").at(**given)
    findings = record_of(
        task_of(REFERENCE, "dissipating-body", instance, truth_of(instance), 4)
    ).findings
    return {(f.check, f.quantity) for f in findings if f.outcome in ("fail", "error")}, sum(
        f.outcome == "pass" for f in findings
    )


def run(**given):
    instance = discovery.case("dissipating-body").at(**given)
    return instance, REFERENCE.run(Request(problem=instance.problem, method="dissipating-body"))[0]


@pytest.mark.parametrize("given", SETS)
def test_the_reference_holds(given):
    failed, passed = failures(**given)
    assert failed == set()
    assert passed >= 8


@pytest.mark.parametrize("given", SETS)
def test_truth_is_what_an_integration_of_the_angular_momentum_says(given):
    instance = discovery.case("dissipating-body").at(**given)
    truth = instance.truth()
    times = [Fraction(1, 2), Fraction(7)]
    for t, said in witnesses()["dissipating-body"].values(instance.p, times, {}):
        for name, ball in truth.at(t).items():
            assert abs(ball.mid - Fraction(str(float(said[name])))) < Fraction(1, 10**14)
            assert abs(said[name] - float(ball.mid)) < 1e-15


def test_angular_momentum_stays_in_space_and_the_energy_falls_to_its_least():
    instance, trajectory = run(duration="400", damping="1/2")
    inertia = instance.p.inertia
    from refdem.mechanics.quaternion import conjugate, rotated

    body = rotated(conjugate(trajectory.attitude[:, 0]), trajectory.omega[:, 0])
    momentum = rotated(trajectory.attitude[:, 0], inertia * body)
    assert np.ptp(momentum, axis=0).max() < 1e-13
    energy = 0.5 * np.sum(inertia * body**2, axis=1)
    assert np.all(np.diff(energy) <= 1e-14)
    assert energy[-1] == pytest.approx(momentum[0] @ momentum[0] / (2 * inertia[2]), rel=1e-12)


@pytest.mark.parametrize(
    ("given", "axis"),
    [
        ({}, 3),
        ({"omega_body": "1,0,0"}, 1),
        ({"omega_body": "0,2,0"}, 2),
        ({"inertia": "3,1,2"}, 1),
        ({"omega_body": "1,1e-3,1e-9"}, 3),
    ],
)
def test_the_last_axis_is_proved(given, axis):
    assert (
        discovery.case("dissipating-body").at(**given).truth().scalars()["final_axis"].mid == axis
    )


def test_an_axis_that_is_not_decided_is_not_said():
    assert discovery.case("dissipating-body").at(damping="0").truth().scalars() == {}
    assert discovery.case("dissipating-body").at(inertia="1,2,2").truth().scalars() == {}


@pytest.mark.parametrize("factor", [-1.0, 0.0, 2.0])
def test_damping_that_is_wrong_is_seen(monkeypatch, factor):
    from refdem.solvers.dissipating_body import DissipatingBody

    whole = DissipatingBody.run

    def wrong(self, request):
        scene = request.problem.scene
        element = request.problem.scene.elements[0]
        object.__setattr__(scene, "elements", (changed(element, factor),))
        return whole(self, request)

    monkeypatch.setattr(DissipatingBody, "run", wrong)
    failed, _ = failures()
    assert ("error", "omega_body.x") in failed
    assert (("energy", "balance") in failed) == (factor < 0)


def changed(element, factor):
    return InternalDamping(a=element.a, coefficient=element.coefficient * factor)


def test_engines_without_it_refuse():
    problem = discovery.case("dissipating-body").at().problem
    for name in ("mujoco", "pymunk", "rebound"):
        engine = discovery.engine(name)
        assert all(engine.unsupported(problem, method) for method in engine.methods)
