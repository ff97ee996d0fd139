"""Sliding friction of the linear contact law, and forces by mjcb_passive, against certified truth;
with errors planted in what the adapter says.
"""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import angular, angular_scale, linear, momentum_scale
from refdem.core.problem import Motion, Request
from refdem.engines.mujoco import options, passive, solver
from refdem.scene import Body, Scene, force_rows
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.spring import Spring
from tests.engines.accuracy import STRENGTHS, misread

OBLIQUE = {"damping": "0", "angle": "1/2", "friction": "1/4", "masses": "1,3", "radii": "1/2,3/4"}
ROUGH = [
    OBLIQUE,
    {"damping": "0", "angle": "1", "friction": "1/10"},
    {"damping": "2", "cutoff": "zero_force", "angle": "1/2", "friction": "1/2"},
    {"damping": "0", "angle": "1/4", "friction": "1/16", "spins": "0,0,2,0,0,-1"},
]
FORCES = [
    ("power-oscillator", {}),
    ("quadratic-response", {"duration": "4"}),
    ("van-der-pol", {"mu": "3/4", "duration": "4"}),
    ("two-body-orbit", {"eccentricity": "1/4", "gm": "2", "duration": "4"}),
    ("asymmetric-field", {}),
    ("whirling-shaft", {"duration": "4"}),
]


def played(engine, method, case, given, steps):
    """The instance, and its trajectory with `steps` steps a sample."""
    instance = discovery.case(case).at(samples="8", **given)
    assert engine.unsupported_motion(instance.problem, engine.method(method)) is None
    step = instance.problem.interval / steps
    run, _ = engine.run(Request(problem=instance.problem, method=method, step=step))
    return instance, run


def error(engine, method, case, given, steps):
    """The largest error of any quantity at any sample, in units of its scale."""
    instance, run = played(engine, method, case, given, steps)
    seen = instance.observe(run)
    truth = instance.truth()
    largest = 0.0
    for row, t in enumerate(instance.problem.times):
        certified = truth.at(Fraction(float(t)))
        for name, quantity in instance.quantities.items():
            departure = abs(seen[name][row] - float(certified[name].mid)) / quantity.scale
            largest = max(largest, departure)
    return largest


@pytest.mark.parametrize("method", ["euler", "implicitfast"])
@pytest.mark.parametrize("given", ROUGH, ids=str)
def test_sliding_friction_of_the_linear_law_is_that_of_certified_truth(engine, method, given):
    coarse = error(engine, method, "two-spheres", given, 32)
    fine = error(engine, method, "two-spheres", given, 512)
    assert fine < 1e-3
    assert np.log2(coarse / fine) / 4 == pytest.approx(1, abs=0.15)


@pytest.mark.parametrize("given", ROUGH, ids=str)
def test_slip_does_not_lift_what_slides_however_short_the_step(engine, given):
    """With MuJoCo's own ratio of impedances the error grows again as the step falls."""
    assert error(engine, "rk4", "two-spheres", given, 2048) < 2e-5


def test_with_the_impedances_that_mujoco_comes_with_slip_does_lift(engine, monkeypatch):
    monkeypatch.setattr(solver, "LIFTLESS", options.FRICTION_TO_NORMAL)
    assert error(engine, "rk4", "two-spheres", OBLIQUE, 2048) > 1e-2


def test_without_the_post_solver_friction_is_soft(engine, monkeypatch):
    monkeypatch.setattr(options, "NOSLIP", 0)
    assert error(engine, "euler", "two-spheres", OBLIQUE, 256) > 1e-2


@pytest.mark.parametrize("given", ROUGH, ids=str)
def test_friction_keeps_momentum_to_round_off_and_angular_momentum_to_the_step(engine, given):
    instance, run = played(engine, "euler", "two-spheres", given, 256)
    total = linear(instance.scene, run)
    turn = angular(instance.scene, run)["total"]
    assert np.abs(total - total[0]).max() < 1e-13 * momentum_scale(instance)
    assert np.abs(turn - turn[0]).max() < 1e-3 * angular_scale(instance)
    spins = np.abs(run.omega - run.omega[0]).max()
    assert spins > 1e-2


@pytest.mark.parametrize(("case", "given"), FORCES, ids=str)
@pytest.mark.parametrize("method", ["euler", "rk4"])
def test_a_force_by_callback_is_that_of_certified_truth(engine, method, case, given):
    fine = error(engine, method, case, given, 512)
    if method == "rk4":
        assert fine < 1e-6
    else:
        assert fine < 2e-2
        coarse = error(engine, method, case, given, 64)
        assert np.log2(coarse / fine) / 3 == pytest.approx(1, abs=0.35)


@pytest.mark.parametrize(
    ("kind", "case", "given"),
    [
        (force_rows.SPRING, "power-oscillator", {"duration": "2"}),
        (force_rows.SPRING, "quadratic-response", {"duration": "2"}),
        (force_rows.DRIVE, *FORCES[1]),
        (force_rows.DASHPOT, *FORCES[2]),
        (force_rows.CENTRAL, *FORCES[3]),
        (force_rows.PIECEWISE, *FORCES[4]),
    ],
)
@pytest.mark.parametrize("factor", [-1.0, 0.5])
def test_a_wrong_sign_or_factor_of_a_force_shows(engine, monkeypatch, kind, case, given, factor):
    right = passive._pushes

    def planted(scene):
        for push in right(scene):
            if push.kind == kind:
                push = replace(push, numbers=misread(push.numbers, STRENGTHS[kind], factor))
            yield push

    monkeypatch.setattr(passive, "_pushes", planted)
    assert error(engine, "rk4", case, given, 64) > 1e-2


@pytest.mark.parametrize(
    "element",
    [
        Spring(a=0, b=1, stiffness=3.0, length=0.5, exponent=1.5),
        Dashpot(a=0, b=1, damping=0.5, van_der_pol=0.25),
        Force(a=0, b=1, amplitude=2.0, frequency=1.0, axis=(1.0, 0.0, 0.0)),
    ],
    ids=lambda element: element.kind,
)
def test_a_force_between_two_bodies_acts_on_both(engine, element):
    pair = [
        Body(mass=1.0, position=(1.0, 0.25, 0.0), velocity=(0.0, 0.5, 0.0)),
        Body(mass=3.0, position=(0.0, 0.0, 0.5), velocity=(0.1, -0.2, 0.0)),
    ]
    problem = Motion(Scene.of(pair, [element]), np.arange(9) / 4)
    run, _ = engine.run(Request(problem=problem, method="rk4", step=2.0**-7))
    mass = np.array([1.0, 3.0])
    total = np.einsum("n,tnk->tk", mass, run.velocity)
    assert np.abs(total - total[0]).max() < 1e-14
    assert np.abs(run.velocity - run.velocity[0]).max() > 0.1
