"""Gear's predictor-corrector: coefficients from conditions, orders against certified truth, drift
of energy, and wrong coefficients that the check of the order must see.
"""

from fractions import Fraction
from math import comb

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.problem import Motion, Request
from refdem.core.refinement import levels
from refdem.core.variant import Variant
from refdem.engines.reference import ENGINE
from refdem.mechanics.energy import kinetic
from refdem.mechanics.quaternion import angle_between
from refdem.scene import Body, Scene
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _gear
from refdem.truth.sampled import sampled
from tests.handmade import all_runs

ORDERS = (4, 5, 6)
GIVEN = {"omega_body": "0.875,1.125,1.25"}
OMEGA = tuple(f"omega_body.{axis}" for axis in "xyz")
ATTITUDE = tuple(f"attitude.{axis}" for axis in "wxyz")
PLACES = ("x", "y")
VELOCITIES = ("vx", "vy")
TIMES = np.arange(5) * 2.0


def corrector(order: int, *, with_velocities: bool = False) -> list[Fraction]:
    """The coefficients of a method as exact numbers."""
    first, *rest = _gear.CORRECTORS[order]
    if with_velocities:
        first = _gear.WITH_VELOCITIES[order]
    return [first, *rest]


def row_errors(coefficients: list[Fraction], degree: int, steps: int) -> list[list[Fraction]]:
    """What rows lack of those of x = t^degree, whose x'' is known, after each step h = 1 from right
    rows.
    """
    count = len(coefficients)
    errors = [[Fraction(0)] * count]
    for n in range(steps):
        exact = [Fraction(comb(degree, i) * n ** (degree - i)) for i in range(count)]
        exact_next = [Fraction(comb(degree, i) * (n + 1) ** (degree - i)) for i in range(count)]
        row = [a + b for a, b in zip(exact, errors[-1], strict=True)]
        predicted = [sum(comb(j, i) * row[j] for j in range(i, count)) for i in range(count)]
        d = exact_next[2] - predicted[2]
        corrected = [a + c * d for a, c in zip(predicted, coefficients, strict=True)]
        errors.append([a - b for a, b in zip(corrected, exact_next, strict=True)])
    return errors


@pytest.mark.parametrize("order", ORDERS)
def test_errors_of_high_rows_vanish_within_as_many_steps(order):
    coefficients = corrector(order)
    high = range(3, order + 1)
    rows = [[comb(j, i) - coefficients[i] * comb(j, 2) for j in high] for i in high]
    power = np.array(rows, object)
    for _ in high:
        power = power.dot(np.array(rows, object))
    assert coefficients[2] == 1
    assert not power.any()


@pytest.mark.parametrize("order", ORDERS)
def test_velocities_are_exact_one_degree_beyond_the_rows(order):
    errors = row_errors(corrector(order), order + 1, 3 * order)
    assert errors[-1][1] == errors[-2][1]


@pytest.mark.parametrize("order", ORDERS)
def test_places_of_forces_with_velocities_gain_no_more_than_the_velocity_is_off(order):
    errors = row_errors(corrector(order, with_velocities=True), order + 1, 3 * order)
    assert errors[-1][0] - errors[-2][0] == errors[-1][1]


@pytest.mark.parametrize("order", ORDERS)
def test_places_without_velocities_have_the_order_of_their_own_recurrence_raised_by_one(order):
    """For x = t^(order + 2) the errors of places have no second difference, so that the recurrence
    of places alone, from which velocities are eliminated, is exact.
    """
    errors = row_errors(corrector(order), order + 2, 3 * order)
    last, middle, first = errors[-1][0], errors[-2][0], errors[-3][0]
    assert last - 2 * middle + first == 0


@pytest.mark.parametrize("order", ORDERS)
def test_error_falls_with_the_claimed_order_for_points(solved, largest_error, order):
    scene = discovery.case("duffing").at().scene
    method = f"gear-{order}"
    seen = {}
    for name in ("x", "v"):
        errors = [
            largest_error("duffing", solved(scene, TIMES, method, 2.0**-k), (name,))
            for k in (5, 6, 7)
        ]
        seen[name] = np.log2(np.divide(errors[:-1], errors[1:]))
    assert ENGINE.method(method).order == order
    assert seen["v"] == pytest.approx(order, abs=0.4)
    # Places gain an order: this force does not depend on velocities.
    assert seen["x"] == pytest.approx(order + 1, abs=0.25)


@pytest.mark.parametrize("names", [OMEGA, ATTITUDE])
@pytest.mark.parametrize("order", ORDERS)
def test_error_falls_with_the_claimed_order_for_bodies(solved, largest_error, order, names):
    scene = discovery.case("free-rigid-body").at(**GIVEN).scene
    method = f"gear-{order}-free-body"
    errors = [
        largest_error("free-rigid-body", solved(scene, TIMES, method, 2.0**-k), names, **GIVEN)
        for k in (6, 7, 8)
    ]
    seen = np.log2(np.divide(errors[:-1], errors[1:]))
    assert ENGINE.method(method).order == order
    assert seen == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("order", ORDERS)
def test_a_parabola_is_exact_in_both_directions_of_time(solved, order):
    body = Body(mass=2.0, position=(1.0, 2.0, 3.0), velocity=(0.5, 0.0, 4.0))
    scene = Scene.of([body], [UniformGravity(g=(0.0, 0.0, -8.0))])
    for sign in (1.0, -1.0):
        times = sign * np.arange(3)
        run = solved(scene, times, f"gear-{order}", 2.0**-6)
        assert run.velocity[:, 0, 2] == pytest.approx(4.0 - 8.0 * times, abs=1e-13)
        assert run.position[:, 0, 2] == pytest.approx(3.0 + 4.0 * times - 4.0 * times**2, abs=1e-13)
        assert run.position[:, 0, 0] == pytest.approx(1.0 + 0.5 * times, abs=1e-15)


def test_energy_drifts_where_the_symplectic_method_only_oscillates(solved):
    """Over 64 periods of the harmonic oscillator, with 24 evaluations of the force each, energy
    grows by 3.4 % and 0.47 % at orders 4 and 5, and falls by 0.18 % at order 6.
    """
    scene = discovery.case("harmonic-oscillator").at().scene
    times = 2.0 * np.pi * np.arange(65)
    gained = {}
    for order in ORDERS:
        run = solved(scene, times, f"gear-{order}", 2.0 * np.pi / 24)
        energy = run.velocity[:, 0, 0] ** 2 + run.position[:, 0, 0] ** 2
        gained[order] = energy / energy[0] - 1.0
    verlet = solved(scene, times, "velocity-verlet", 2.0 * np.pi / 24)
    energy = verlet.velocity[:, 0, 0] ** 2 + verlet.position[:, 0, 0] ** 2
    assert np.abs(energy / energy[0] - 1.0).max() < 0.02
    ends = [gained[order][64] for order in ORDERS]
    assert ends == pytest.approx([0.0344, 0.00466, -0.00179], rel=0.01)
    for order in ORDERS:
        assert gained[order][64] == pytest.approx(2.0 * gained[order][32], rel=0.1)


def test_energy_of_a_body_drifts_and_less_at_higher_order(solved):
    scene = discovery.case("free-rigid-body").at(**GIVEN).scene
    off = []
    for order in ORDERS:
        run = solved(scene, np.arange(11) * 10.0, f"gear-{order}-free-body", 2.0**-5)
        inertia = scene.bodies.inertia
        energy = kinetic(np.ones(1), inertia, run.velocity, run.attitude, run.omega)
        drift = np.abs(energy / energy[0] - 1.0)
        assert drift[10] == pytest.approx(2.0 * drift[5], rel=0.5)
        off.append(drift[10])
    # Measured: 1.0e-4, 5.5e-5 and 7.4e-7.
    assert off[0] > off[1] > 25.0 * off[2] > 0.0


def test_errors_of_a_body_keep_their_bound_while_the_quaternion_changes_its_length(solved):
    """Over 128 tau, at most 0.5 (1 + t/tau) (h/tau)^4 S; 2 and more if the scalar part of 2 q^-1 q'
    is left out, so that the drift of the length slows omega.
    """
    instance = discovery.case("free-rigid-body").at()
    tau = instance.scales.tau
    times = np.linspace(0.0, 128.0 * tau, 17)
    step = times[1] / 256
    truth = instance.case.truth(instance.p)
    seen = solved(instance.scene, times, "gear-4-free-body", step)
    exact = solved(instance.scene, times, "exact-free-body")
    growth = [max(1.0, float(truth.sensitivity(Fraction(t)))) for t in times.tolist()]
    allowed = (1 + times / tau) * (step / tau) ** 4 * np.maximum.accumulate(growth)
    off = (
        np.linalg.norm(seen.omega - exact.omega, axis=-1)[:, 0] * tau
        + angle_between(seen.attitude, exact.attitude)[:, 0]
    )
    assert (off / allowed).max() < 0.5


def findings_of_order(case: str, method: str):
    """What the check of the order finds of a method of the reference in a case."""
    instance = discovery.case(case).at()
    claims = ENGINE.method(method)
    steps = levels(instance, claims, 4, 1e9)
    truth = sampled(instance.truth(), instance.times.tolist())
    subject = Subject(instance, claims, steps, truth)

    def made(variant: Variant) -> CompletedRun:
        request = Request(
            problem=Motion(instance.scene, instance.times), method=method, step=variant.level
        )
        trajectory, cost = ENGINE.run(request)
        return CompletedRun(trajectory, cost)

    check = discovery.check("order")
    return check.judge(subject, all_runs(check, subject, made))


@pytest.mark.parametrize(
    ("case", "suffix"), [("harmonic-oscillator", ""), ("free-rigid-body", "-free-body")]
)
@pytest.mark.parametrize("order", ORDERS)
def test_a_wrong_coefficient_is_seen_by_the_check_of_the_order(monkeypatch, case, suffix, order):
    method = f"gear-{order}{suffix}"
    assert findings_of_order(case, method)[0].outcome == "pass"
    right = _gear.CORRECTORS[order]
    wrong = (right[0], right[1] + Fraction(1, 16), *right[2:])
    monkeypatch.setattr(_gear, "CORRECTORS", {order: wrong})
    finding = findings_of_order(case, method)[0]
    assert finding.outcome == "fail"
    assert finding.order_seen < order - 0.15


def test_scenes_that_are_not_smooth_or_turn_are_refused():
    kinked = Scene.of(
        [Body(mass=1.0, position=(2.0, 0.0, 0.0))],
        [Spring(a=0, stiffness=1.0, length=0.5, exponent=1.5)],
    )
    turning = Scene.of([Body(mass=1.0, inertia=(1.0, 1.0, 1.0), omega=(0.0, 0.0, 1.0))])
    rod = Scene.of([Body(mass=1.0, inertia=(0.0, 1.0, 1.0), omega=(0.0, 0.0, 1.0))])
    times = np.array([0.0, 1.0])
    for scene, method, reason in (
        (kinked, "gear-5", "not smooth"),
        (turning, "gear-5", "a body turns"),
        (rod, "gear-5-free-body", "without inertia"),
    ):
        refusal = ENGINE.unsupported_motion(Motion(scene, times), ENGINE.method(method))
        assert reason in str(refusal)
