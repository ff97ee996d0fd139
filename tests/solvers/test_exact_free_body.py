"""The closed form of the free rigid body: against certified truth, its degenerate classes, and what
it keeps.
"""

import itertools

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.mechanics.quaternion import angle_between, product, rotated
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.uniform_gravity import UniformGravity

STATE = tuple(f"omega_body.{a}" for a in "xyz") + tuple(f"attitude.{a}" for a in "wxyz")
PARTS = np.array([0.0, 0.37, 0.5, 0.73, 0.9, 1.0])
ULPS = 80 * 2.0**-53
"""Some twenty operations after the phase, of errors of random sign, are 8 units off at most, and
nothing in it grows with time.
"""


def spinning(inertia, omega, attitude=(1.0, 0.0, 0.0, 0.0)):
    """One free body with omega in space axes."""
    return Scene.of(
        [Body(mass=1.0, inertia=tuple(inertia), omega=tuple(omega), attitude=tuple(attitude))]
    )


@pytest.mark.parametrize("duration", [100.0, -100.0, 1e6])
def test_state_is_right_to_some_ulps_at_any_time(solved, largest_error, duration):
    given = {"omega_body": "0.875,1.125,1.25"}
    scene = discovery.case("free-rigid-body").at(**given).scene
    assert (
        largest_error(
            "free-rigid-body", solved(scene, duration * PARTS, "exact-free-body"), STATE, **given
        )
        < ULPS
    )


@pytest.mark.parametrize("inertia", sorted(itertools.permutations((2, 3, 4))))
def test_axes_may_come_in_any_order_and_omega_with_any_sign(solved, largest_error, inertia):
    signs = itertools.product((1, -1), repeat=3)
    for (x, y, z), size in itertools.product(signs, ((0.875, 1.125, 1.25), (0.25, 1.0, 0.125))):
        given = {
            "inertia": ",".join(map(str, inertia)),
            "omega_body": f"{x * size[0]},{y * size[1]},{z * size[2]}",
        }
        scene = discovery.case("free-rigid-body").at(**given).scene
        assert (
            largest_error(
                "free-rigid-body", solved(scene, (0.0, 9.0), "exact-free-body"), STATE, **given
            )
            < ULPS
        )


@pytest.mark.parametrize(
    ("inertia", "omega"),
    [
        ("1,1,1.5", "0.25,0.5,1"),
        ("1,1.5,1.5", "0.25,0.5,1"),
        ("2,1.5,2", "0.25,0.5,1"),
        ("2,2,2", "0.25,0.5,1"),
        ("1,1.5,1.5", "0,0.5,1"),
        ("3,4,6", "2,1,1"),
        ("3,4,6", "-2,1,1"),
        ("3,4,6", "2,-1,-1"),
        ("6,4,3", "1,-1,2"),
        ("1,2,2.000000000000000444089209850062616169452667236328125", "0.25,0.5,1"),
        ("1,1.0000000000000002220446049250313080847263336181640625,2", "0.25,0.5,1"),
    ],
    ids=[
        "disc",
        "rod",
        "middle",
        "sphere",
        "across",
        "separatrix",
        "left",
        "down",
        "turned",
        "almost-rod",
        "almost-disc",
    ],
)
def test_degenerate_bodies_are_right_to_some_ulps(solved, largest_error, inertia, omega):
    given = {"inertia": inertia, "omega_body": omega}
    scene = discovery.case("free-rigid-body").at(**given).scene
    assert (
        largest_error(
            "free-rigid-body", solved(scene, 9 * PARTS, "exact-free-body"), STATE, **given
        )
        < ULPS
    )


@pytest.mark.parametrize("offset", [2**-10, 2**-30, 2**-40])
@pytest.mark.parametrize("direction", ["1", "3"])
def test_flips_next_to_the_unstable_axis_are_right_to_some_ulps(
    solved, largest_error, offset, direction
):
    given = {"offset": f"1/{int(1 / offset)}", "direction": direction}
    scene = discovery.case("intermediate-axis").at(**given).scene
    trajectory = solved(scene, 200 * PARTS, "exact-free-body")
    assert largest_error("intermediate-axis", trajectory, STATE, **given) < 2 * ULPS


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_spin_about_a_principal_axis_stays_to_the_last_bit(solved, axis):
    omega = 1.75 * np.eye(3)[axis]
    trajectory = solved(
        spinning((1.0, 2.0, 3.0), omega), (0.0, 1.0, 4096.0, 1e6), "exact-free-body"
    )
    assert np.array_equal(trajectory.omega[:, 0], np.tile(omega, (4, 1)))
    half = 0.875 * trajectory.t  # exact
    expected = np.cos(half)[:, None] * (1, 0, 0, 0) + np.sin(half)[:, None] * (0, *np.eye(3)[axis])
    assert trajectory.attitude[:, 0] == pytest.approx(expected, abs=2e-16)


def test_body_a_trillionth_off_the_unstable_axis_flips_when_the_elliptic_period_says(solved):
    # From w = (e, 1, 0) with J = (1, 2, 3): m1 = e^2, rate^2 = (1 + e^2)/3, omega_2 = sn starts at
    # u = K = ln(4/e) and is 0 at 2K.
    offset = 1e-12
    flip = np.log(4.0 / offset) * np.sqrt(3.0)
    trajectory = solved(
        spinning((1.0, 2.0, 3.0), (offset, 1.0, 0.0)),
        (0.0, flip - 1e-9, flip + 1e-9, 2 * flip),
        "exact-free-body",
    )
    w2 = [
        float(rotated(q * (1, -1, -1, -1), w)[1])
        for q, w in zip(trajectory.attitude[:, 0], trajectory.omega[:, 0], strict=True)
    ]
    assert w2[1] > 0 > w2[2]
    assert w2[3] == pytest.approx(-1.0, abs=2e-14)


def test_first_sample_is_the_start_to_the_last_bit(solved):
    attitude = np.array([0.5, -0.5, 0.1, 0.7]) / np.linalg.norm([0.5, -0.5, 0.1, 0.7])
    trajectory = solved(
        spinning((1.0, 2.0, 3.0), (0.9, 1.1, 1.3), attitude), (3.0, 4.0), "exact-free-body"
    )
    assert np.array_equal(trajectory.attitude[0, 0], attitude)
    assert np.array_equal(trajectory.omega[0, 0], (0.9, 1.1, 1.3))


def test_attitude_at_the_start_turns_the_whole_motion_in_space(solved):
    turn = np.array([0.5, 0.5, -0.5, 0.5])
    omega = np.array([0.9, 1.1, 1.3])
    plain = solved(spinning((1.0, 2.0, 3.0), omega), (0.0, 17.0), "exact-free-body")
    turned = solved(
        spinning((1.0, 2.0, 3.0), rotated(turn, omega), turn), (0.0, 17.0), "exact-free-body"
    )
    assert angle_between(turned.attitude[1, 0], product(turn, plain.attitude[1, 0])) < 2e-14
    assert rotated(turn, plain.omega[1, 0]) == pytest.approx(turned.omega[1, 0], abs=1e-14)


def test_motion_with_omega_turned_round_is_the_motion_backwards(solved):
    forward = solved(spinning((1.0, 2.0, 3.0), (0.9, -1.1, 1.3)), (0.0, 33.0), "exact-free-body")
    backward = solved(spinning((1.0, 2.0, 3.0), (-0.9, 1.1, -1.3)), (0.0, -33.0), "exact-free-body")
    assert angle_between(forward.attitude[1, 0], backward.attitude[1, 0]) < 1e-14
    assert forward.omega[1, 0] == pytest.approx(-backward.omega[1, 0], abs=1e-14)


def test_several_bodies_move_each_by_itself(solved):
    ball = Body(
        mass=2.0,
        inertia=(1.0, 1.0, 1.0),
        position=(5.0, 0.0, 0.0),
        velocity=(0.5, -1.0, 2.0),
        omega=(0.0, 0.0, 2.0),
        shape=Sphere(radius=0.5),
    )
    point = Body(mass=1.0, position=(-3.0, 0.0, 0.0), velocity=(0.0, 0.25, 0.0))
    body = Body(mass=1.0, inertia=(1.0, 2.0, 3.0), omega=(0.9, 1.1, 1.3))
    both = solved(Scene.of([ball, point, body]), (0.0, 4.0), "exact-free-body")
    alone = solved(spinning((1.0, 2.0, 3.0), (0.9, 1.1, 1.3)), (0.0, 4.0), "exact-free-body")
    assert np.array_equal(both.position[1], [(7.0, -4.0, 8.0), (-3.0, 1.0, 0.0), (0.0, 0.0, 0.0)])
    assert np.array_equal(both.attitude[1, 2], alone.attitude[1, 0])
    assert (
        angle_between(both.attitude[1, 0], np.array([np.cos(4.0), 0.0, 0.0, np.sin(4.0)])) < 1e-15
    )
    assert np.array_equal(both.attitude[1, 1], (1.0, 0.0, 0.0, 0.0))


def test_scene_with_a_force_or_a_fixed_body_is_refused():
    body = Body(mass=1.0)
    for scene, reason in (
        (Scene.of([body], [UniformGravity(g=(0.0, -9.8, 0.0))]), "uniform_gravity"),
        (Scene.of([Body(mass=1.0, fixed=True)]), "fixed"),
    ):
        problem = Motion(scene, np.array([0.0, 1.0]))
        assert reason in str(ENGINE.unsupported_motion(problem, ENGINE.method("exact-free-body")))
