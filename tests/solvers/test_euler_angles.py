"""Euler angles in two frames: order and errors across the poles, drift beside the quaternion's, and
a numpy version with faults that the checks must see.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.problem import Motion, Request
from refdem.core.refinement import levels
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.variant import Variant
from refdem.engines.reference import ENGINE
from refdem.mechanics.energy import kinetic
from refdem.mechanics.momentum import spin
from refdem.mechanics.quaternion import (
    angle_between,
    conjugate,
    matrix,
    product,
    rotated,
    turned_by,
)
from refdem.scene import Body, Scene
from refdem.truth.sampled import sampled
from tests.handmade import all_runs

Array = NDArray[np.float64]

METHOD = "euler-angles"
CASE = "free-rigid-body"
GIVEN = {"omega_body": "0.875,1.125,1.25"}
OMEGA = tuple(f"omega_body.{axis}" for axis in "xyz")
ATTITUDE = tuple(f"attitude.{axis}" for axis in "wxyz")
FRAMES = np.array([[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5]])
"""What turns a frame of the angles into space: nothing, or 120 degrees about (1, 1, 1)."""


def alone(bodies, attitude: Array, omega: Array) -> Scene:
    """A scene of the first of some bodies with this attitude (4,) and omega (3,) [rad/s]."""
    body = Body(
        mass=float(bodies.mass[0]),
        inertia=tuple(bodies.inertia[0]),
        attitude=tuple(attitude),
        omega=tuple(omega),
    )
    return Scene.of([body])


def before_the_pole(solved, seconds: float, **given: str) -> Scene:
    """The body of the case so many seconds before its axes are those of space, where theta = 0."""
    scene = discovery.case(CASE).at(**given).scene
    earlier = solved(scene, (0.0, -seconds), "exact-free-body")
    return alone(scene.bodies, earlier.attitude[1, 0], earlier.omega[1, 0])


def turned_in_space(run: Trajectory, turn: Array) -> Trajectory:
    """The same motion, turned as a whole by a unit quaternion `turn` (4,)."""
    return replace(run, attitude=product(turn, run.attitude), omega=rotated(turn, run.omega))


# From 3 s before, a step ends at the pole; from 8/3 s before, the pole lies within a step. Tilted,
# the body passes the pole at some distance.
@pytest.mark.parametrize("seconds", [3.0, 8.0 / 3.0])
@pytest.mark.parametrize("tilt", [0.0, 1e-9, 1e-3, 0.5])
@pytest.mark.parametrize("names", [OMEGA, ATTITUDE])
def test_error_falls_with_the_claimed_order_across_the_pole(
    solved, largest_error, seconds, tilt, names
):
    scene = before_the_pole(solved, seconds, **GIVEN)
    times = np.arange(5) * 2.0 - seconds
    turn = turned_by(np.array([0.0, tilt, 0.0]))
    bodies = scene.bodies
    tilted = alone(bodies, product(turn, bodies.attitude[0]), rotated(turn, bodies.omega[0]))
    errors = []
    for k in (5, 6, 7, 8):
        seen = turned_in_space(solved(tilted, times, METHOD, 2.0**-k), conjugate(turn))
        errors.append(largest_error(CASE, seen, names, **GIVEN))
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert ENGINE.method(METHOD).order == 4
    assert orders == pytest.approx(4, abs=0.1)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 1, 1)])
@pytest.mark.parametrize("start", [*FRAMES, (0, 1, 0, 0), (0, 0, 1, 0), (1, 0, 1, 0), (1, 1, 0, 0)])
def test_turns_of_a_ball_about_axes_agree_from_every_pole(solved, start, axis):
    """Each start has the body's z axis along or against an axis of space, and so on a pole of one
    frame or on neither; h^4 is 6e-8.
    """
    omega = np.array(axis, float)
    ball = Scene.of(
        [
            Body(
                mass=1.0,
                inertia=(2.0, 2.0, 2.0),
                attitude=tuple(np.array(start) / np.linalg.norm(start)),
                omega=tuple(omega),
            )
        ]
    )
    for sign in (1.0, -1.0):
        times = sign * np.arange(9.0)
        seen = solved(ball, times, METHOD, 2.0**-6)
        exact = product(turned_by(times[:, None] * omega), seen.attitude[0, 0])
        assert angle_between(seen.attitude[:, 0], exact).max() < 6e-8
        assert seen.omega[:, 0] == pytest.approx(np.tile(omega, (9, 1)), abs=6e-8)


def test_energy_and_size_of_the_momentum_drift_as_with_the_quaternion_but_its_direction_more(
    solved,
):
    """Over 1000 s in steps of 1/8 s both lose 9.0e-4 of the energy and 3.2e-4 of |L|; L turns by
    5.5e-3 rad in Euler angles, and by 1e-5 rad in the quaternion.
    """
    scene = discovery.case(CASE).at(**GIVEN).scene
    inertia = scene.bodies.inertia
    lost = {}
    turned = {}
    for method in (METHOD, "rk4-free-body"):
        run = solved(scene, np.arange(3) * 500.0, method, 0.125)
        energy = kinetic(np.ones(1), inertia, run.velocity, run.attitude, run.omega)
        momentum = spin(inertia, run.attitude, run.omega)
        size = np.linalg.norm(momentum, axis=-1)
        direction = momentum / size[:, None]
        lost[method] = (energy / energy[0] - 1.0, size / size[0] - 1.0)
        turned[method] = np.linalg.norm(direction - direction[0], axis=-1)
    assert lost[METHOD] == pytest.approx(np.array(lost["rk4-free-body"]), abs=1e-10)
    assert lost[METHOD][0][2] == pytest.approx(-8.98e-4, rel=0.01)
    assert lost[METHOD][1][2] == pytest.approx(-3.21e-4, rel=0.01)
    assert turned[METHOD][2] == pytest.approx(5.45e-3, rel=0.02)
    assert turned[METHOD][2] > 500 * turned["rk4-free-body"][2]


def test_a_run_continues_from_its_end_as_if_it_had_not_stopped(solved):
    scene = before_the_pole(solved, 3.0, **GIVEN)
    whole = solved(scene, np.arange(65) * 0.125, METHOD, 0.0625)
    for stop in range(0, 64, 7):
        rest = alone(scene.bodies, whole.attitude[stop, 0], whole.omega[stop, 0])
        again = solved(rest, (0.0, 0.125), METHOD, 0.0625)
        assert angle_between(again.attitude[1], whole.attitude[stop + 1]).max() < 1e-14
        assert again.omega[1] == pytest.approx(whole.omega[stop + 1], abs=1e-14)


def angles_of(attitude: Array, frame: int) -> Array:
    """Angles (phi, theta, psi) of an attitude, from the matrix of the chapter's 1.3.7."""
    rows = matrix(product(conjugate(FRAMES[frame]), attitude)).T
    theta = np.arccos(np.clip(rows[2, 2], -1.0, 1.0))
    phi = np.arctan2(rows[2, 0], -rows[2, 1])
    psi = np.arctan2(rows[0, 2], rows[1, 2])
    return np.array([phi, theta, psi])


def attitude_of(angles: Array, frame: int) -> Array:
    """The attitude after turns about z, about the new x and about the new z, seen in a frame."""
    about_z, about_x, about_new_z = angles[:, None] * np.array([[0, 0, 1], [1, 0, 0], [0, 0, 1]])
    turns = product(product(turned_by(about_z), turned_by(about_x)), turned_by(about_new_z))
    return product(FRAMES[frame], turns)


def rates(y: Array, inertia: Array, sign: float) -> Array:
    """Rates of the angles and of omega in body axes; right where `sign`, that of omega's second
    component in theta', is -1.
    """
    _, theta, psi = y[:3]
    wx, wy, wz = y[3:]
    phi_rate = (wx * np.sin(psi) + wy * np.cos(psi)) / np.sin(theta)
    theta_rate = wx * np.cos(psi) + sign * wy * np.sin(psi)
    psi_rate = wz - phi_rate * np.cos(theta)
    omega_rate = np.cross(inertia * y[3:], y[3:]) / inertia
    return np.array([phi_rate, theta_rate, psi_rate, *omega_rate])


def run_in_numpy(request: Request, *, sign: float = -1.0, switches: bool = True) -> Trajectory:
    """The method in plain numpy, with a fault where `sign` is 1 or it keeps the first frame."""
    times = request.problem.times
    bodies = request.problem.scene.bodies
    inertia = bodies.inertia[0]
    attitude = bodies.attitude[0] / np.linalg.norm(bodies.attitude[0])
    h = request.step * np.sign(times[1] - times[0])
    body_z = np.array([0.0, 0.0, 1.0])
    frame = int(rotated(attitude, body_z)[2] ** 2 > 0.5)
    body_omega = rotated(conjugate(attitude), bodies.omega[0])
    y = np.array([*angles_of(attitude, frame), *body_omega])
    attitudes = [attitude]
    omegas = [bodies.omega[0]]
    for _ in times[1:]:
        for _ in range(round((times[1] - times[0]) / h)):
            attitude = attitude_of(y[:3], frame)
            away = int(rotated(attitude, body_z)[2] ** 2 > 0.5)
            if switches and away != frame:
                frame = away
                y[:3] = angles_of(attitude, frame)
            k1 = rates(y, inertia, sign)
            k2 = rates(y + h / 2 * k1, inertia, sign)
            k3 = rates(y + h / 2 * k2, inertia, sign)
            k4 = rates(y + h * k3, inertia, sign)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        attitudes.append(attitude_of(y[:3], frame))
        omegas.append(rotated(attitudes[-1], y[3:]))
    still = np.zeros((len(times), 1, 3))
    return Trajectory(
        t=times,
        position=still + bodies.position,
        velocity=still + bodies.velocity,
        attitude=np.array(attitudes)[:, None],
        omega=np.array(omegas)[:, None],
    )


def outcomes(made: Callable[[Request], Trajectory], check_id: str, **given: str) -> set[str]:
    """What a check says of the quantities of the case where `made` answers requests."""
    instance = discovery.case(CASE).at(**given)
    claims = ENGINE.method(METHOD)
    truth = sampled(instance.truth(), instance.times.tolist())
    subject = Subject(instance, claims, levels(instance, claims, 3, 1e9), truth)

    def completed(variant: Variant) -> CompletedRun:
        problem = Motion(instance.scene, instance.times)
        request = Request(problem=problem, method=METHOD, step=variant.level)
        return CompletedRun(made(request), Cost(seconds=0.0))

    check = discovery.check(check_id)
    judged = check.judge(subject, all_runs(check, subject, completed))
    return {finding.outcome for finding in judged}


# Turns about the axis of the middle moment, with theta = pi/2 of the second frame's own pole.
TUMBLING = {"omega_body": "1/64,1,1/64", "duration": "8", "samples": "8"}


def test_numpy_version_agrees_to_rounding(solved):
    scene = before_the_pole(solved, 3.0, **GIVEN)
    times = np.arange(9) * 1.0
    seen = solved(scene, times, METHOD, 0.125)
    plain = run_in_numpy(Request(problem=Motion(scene, times), method=METHOD, step=0.125))
    assert angle_between(seen.attitude, plain.attitude).max() < 1e-13
    assert seen.omega == pytest.approx(plain.omega, abs=1e-13)


@pytest.mark.parametrize("check_id", ["error", "order"])
def test_numpy_version_passes_the_checks(check_id):
    assert outcomes(run_in_numpy, check_id, **TUMBLING) == {"pass"}


def test_wrong_sign_in_one_rate_is_seen_by_the_check_of_the_error():
    def wrong(request: Request) -> Trajectory:
        return run_in_numpy(request, sign=1.0)

    assert "fail" in outcomes(wrong, "error", **TUMBLING)


def test_one_frame_alone_is_seen_by_the_checks():
    def wrong(request: Request) -> Trajectory:
        return run_in_numpy(request, switches=False)

    assert "fail" in outcomes(wrong, "error", **TUMBLING)
    assert "fail" in outcomes(wrong, "order", **TUMBLING)


def test_nothing_that_turns_is_refused_and_a_rod_without_moment_about_its_axis_is_not(solved):
    still = Motion(Scene.of([Body(mass=1.0, velocity=(1.0, 0.0, 0.0))]), np.array([0.0, 1.0]))
    assert "nothing turns" in str(ENGINE.unsupported_motion(still, ENGINE.method(METHOD)))
    rod = Scene.of([Body(mass=1.0, inertia=(0.0, 1.0, 1.0), omega=(0.0, 0.0, 1.0))])
    end = solved(rod, (0.0, 3.0), METHOD, 0.0078125).attitude[1, 0]
    assert end == pytest.approx([np.cos(1.5), 0, 0, np.sin(1.5)], abs=1e-10)
