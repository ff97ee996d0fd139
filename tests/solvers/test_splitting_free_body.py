"""The free rigid body by steps: splitting and Runge-Kutta against certified truth, and what each
keeps.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.mechanics.energy import kinetic
from refdem.mechanics.momentum import spin
from refdem.mechanics.quaternion import angle_between
from refdem.scene import Body, Scene

STATE = tuple(f"omega_body.{a}" for a in "xyz") + tuple(f"attitude.{a}" for a in "wxyz")
GIVEN = {"omega_body": "0.875,1.125,1.25"}
INERTIA = np.array([[1.0, 2.0, 3.0]])
TIMES = np.arange(5) * 2.0


@pytest.fixture
def scene():
    return discovery.case("free-rigid-body").at(**GIVEN).scene


@pytest.mark.parametrize(("method", "order"), [("splitting-free-body", 2), ("rk4-free-body", 4)])
def test_error_falls_with_the_claimed_order(solved, largest_error, scene, method, order):
    errors = [
        largest_error("free-rigid-body", solved(scene, TIMES, method, 2.0**-k), STATE, **GIVEN)
        for k in (4, 5, 6, 7)
    ]
    seen = np.log2(np.divide(errors[:-1], errors[1:]))
    assert seen == pytest.approx(order, abs=0.1)
    assert ENGINE.method(method).order == order


@pytest.mark.parametrize(
    "inertia",
    [
        "1,2,3",
        "1/128,1,257/256",
        "1,1048577/1048576,1/524288",
        f"{2**-40},1,{1 + 2**-41}",
        "1,1/64,65/64",
    ],
)
def test_splitting_claims_a_constant_that_holds_for_needles_and_plates(solved, inertia):
    """In place of 1/8 that a bound allows, at most 0.003 (1 + t/tau) S; turns about all three axes
    have 1e8 of it at 2^-40.
    """
    instance = discovery.case("free-rigid-body").at(inertia=inertia)
    truth = instance.case.truth(instance.p)
    tau = instance.scales.tau
    step = 2.0**-5
    seen = solved(instance.scene, TIMES, "splitting-free-body", step)
    exact = solved(instance.scene, TIMES, "exact-free-body")
    grown = np.maximum.accumulate(
        [max(1.0, float(truth.sensitivity(Fraction(t)))) for t in TIMES.tolist()]
    )
    allowed = (1 + TIMES / tau) * (step / tau) ** 2 * grown
    off = (
        np.linalg.norm(seen.omega - exact.omega, axis=-1)[:, 0] * tau
        + angle_between(seen.attitude, exact.attitude)[:, 0]
    )
    assert (off / allowed).max() < 0.01 < ENGINE.method("splitting-free-body").constant


def test_splitting_is_exact_for_symmetric_bodies(solved):
    for inertia in ("1,1,2", "1,1,1/64", "1/128,1,1", "3/2,1,3/2"):
        start = discovery.case("free-rigid-body").at(inertia=inertia).scene
        seen = solved(start, TIMES, "splitting-free-body", 1.0)
        exact = solved(start, TIMES, "exact-free-body")
        assert angle_between(seen.attitude, exact.attitude).max() < 1e-13, inertia
        assert np.abs(seen.omega - exact.omega).max() < 1e-13, inertia


@pytest.mark.parametrize("method", ["splitting-free-body", "rk4-free-body"])
def test_quaternion_stays_a_unit_one(solved, scene, method):
    trajectory = solved(scene, TIMES, method, 0.25)
    assert np.linalg.norm(trajectory.attitude, axis=-1) == pytest.approx(np.ones((5, 1)), abs=4e-16)


def test_splitting_keeps_angular_momentum_in_space_over_1e5_steps(solved, scene):
    trajectory = solved(scene, np.arange(11) * 625.0, "splitting-free-body", 0.0625)
    momentum = spin(INERTIA, trajectory.attitude, trajectory.omega)
    size = np.linalg.norm(momentum[0])
    # 5e5 turns by about 0.1: in increments each adds u times its angle, which makes sqrt(5e5) 0.1
    # u; plain products add u each.
    assert np.abs(momentum - momentum[0]).max() < 256 * 2.0**-53 * size


def test_splitting_has_no_drift_of_energy(solved, scene):
    trajectory = solved(scene, np.arange(2001) * 5.0, "splitting-free-body", 0.0625)
    energy = kinetic(
        np.ones(1), INERTIA, trajectory.velocity, trajectory.attitude, trajectory.omega
    )
    off = np.abs(energy / energy[0] - 1)
    assert off[1001:].max() < 1.05 * off[:1001].max() < 1e-3


def test_runge_kutta_loses_energy_where_splitting_does_not(solved, scene):
    times = np.arange(201) * 50.0
    off = {}
    for method in ("splitting-free-body", "rk4-free-body"):
        trajectory = solved(scene, times, method, 0.25)
        energy = kinetic(
            np.ones(1), INERTIA, trajectory.velocity, trajectory.attitude, trajectory.omega
        )
        off[method] = np.abs(energy / energy[0] - 1)
    assert off["rk4-free-body"][-1] > 1.5 * off["rk4-free-body"][100] > 1e-3
    assert off["splitting-free-body"][100:].max() < 1.05 * off["splitting-free-body"][:101].max()


def test_splitting_run_back_with_negative_step_returns(solved, scene):
    there = solved(scene, (0.0, 250.0), "splitting-free-body", 0.0625)
    end = scene.with_state(**there.end())
    back = solved(end, (250.0, 0.0), "splitting-free-body", 0.0625)
    assert angle_between(back.attitude[1], scene.bodies.attitude) == pytest.approx(0.0, abs=2e-12)
    assert back.omega[1] == pytest.approx(scene.bodies.omega, abs=2e-12)


def test_splitting_with_omega_turned_round_retraces_its_steps(solved, scene):
    there = solved(scene, (0.0, 1.0, 2.0), "splitting-free-body", 0.125)
    turned = scene.with_state(attitude=there.attitude[-1], omega=-there.omega[-1])
    back = solved(turned, (0.0, 1.0, 2.0), "splitting-free-body", 0.125)
    assert angle_between(back.attitude[1:, 0], there.attitude[1::-1, 0]) == pytest.approx(
        np.zeros(2), abs=5e-15
    )
    assert back.omega[1:] == pytest.approx(-there.omega[1::-1], abs=5e-15)


@pytest.mark.parametrize("method", ["splitting-free-body", "rk4-free-body"])
def test_nothing_that_turns_is_refused(method):
    problem = Motion(Scene.of([Body(mass=1.0, velocity=(1.0, 0.0, 0.0))]), np.array([0.0, 1.0]))
    assert "nothing turns" in str(ENGINE.unsupported_motion(problem, ENGINE.method(method)))


def test_thin_rod_without_moment_about_its_axis_turns_over_its_end(solved):
    scene = Scene.of([Body(mass=1.0, inertia=(0.0, 1.0, 1.0), omega=(0.0, 0.0, 1.0))])
    for method, step in (
        ("splitting-free-body", 0.125),
        ("rk4-free-body", 0.0078125),
        ("exact-free-body", None),
    ):
        trajectory = solved(scene, (0.0, 3.0), method, step)
        assert trajectory.attitude[1, 0] == pytest.approx(
            [np.cos(1.5), 0, 0, np.sin(1.5)], abs=1e-10
        )
