"""The pendulum in closed form: against certified truth, known periods, its three kinds of motion
and its equilibria.
"""

import numpy as np
import pytest
from flint import acb

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

QUANTITIES = ("x", "y", "thetadot", "rod_force")
PARTS = np.array([0.0, 0.37, 0.5, 0.73, 0.9, 1.0])
RIGHT_ANGLE_PERIOD = 1.18034059901609622604
"""2 K(1/sqrt 2)/pi, amplitude 90 degrees over small amplitude; OEIS A175574."""


def hanging(
    position, velocity, g=(0.0, -9.8125, 0.0), mass=1.0, anchor=(0.0, 0.0, 0.0), length=1.0
):
    """A point on a rod."""
    place = tuple(np.add(anchor, position))
    body = Body(mass=mass, position=place, velocity=tuple(velocity))
    return Scene.of([body], [Rod(a=0, length=length, anchor_b=tuple(anchor)), UniformGravity(g=g)])


@pytest.mark.parametrize(
    "rate", ["1/1024", "3", "4.421875", "4.4375", "-6.25", "6.265625", "-7", "40"]
)
@pytest.mark.parametrize("duration", [210.0, -2e5])
def test_state_is_right_to_some_ulps_after_any_number_of_periods(
    solved, largest_error, rate, duration
):
    given = {"theta0": "0", "thetadot0": rate}
    scene = discovery.case("pendulum").at(**given).scene
    assert (
        largest_error(
            "pendulum", solved(scene, duration * PARTS, "exact-pendulum"), QUANTITIES, **given
        )
        < 1e-14
    )


@pytest.mark.parametrize("sense", [1, -1])
def test_separatrix_is_tanh_and_sech(solved, largest_error, sense):
    given = {"theta0": "0", "thetadot0": str(8 * sense), "gravity": "16"}
    scene = discovery.case("pendulum").at(**given).scene
    trajectory = solved(scene, 6 * PARTS, "exact-pendulum")
    assert largest_error("pendulum", trajectory, QUANTITIES, **given) < 2e-15
    assert trajectory.position[1:, 0, 0] == pytest.approx(
        sense * 2 * np.tanh(24 * PARTS[1:]) / np.cosh(24 * PARTS[1:]), abs=1e-15
    )


def test_swing_from_the_horizontal_has_the_known_period(solved):
    g = 9.8125
    quarter = RIGHT_ANGLE_PERIOD * np.pi / 2 / np.sqrt(g)
    trajectory = solved(
        hanging((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), quarter * np.arange(5), "exact-pendulum"
    )
    assert trajectory.position[:, 0] == pytest.approx(
        np.array([(1, 0, 0), (0, -1, 0), (-1, 0, 0), (0, -1, 0), (1, 0, 0)]), abs=1e-14
    )
    assert trajectory.velocity[1, 0] == pytest.approx([-np.sqrt(2 * g), 0.0, 0.0], abs=1e-14)
    assert trajectory.channels["rod_force"][:, 0] == pytest.approx(
        [0, 3 * g, 0, 3 * g, 0], abs=2e-14
    )


def test_swing_from_two_radians_comes_back_after_a_hundred_periods(solved):
    period = float((4 * (acb(1).sin() ** 2).elliptic_k() / acb(9.8125).sqrt()).real)
    start = (np.sin(2.0), -np.cos(2.0), 0.0)
    trajectory = solved(hanging(start, (0.0, 0.0, 0.0)), (0.0, 100 * period), "exact-pendulum")
    assert trajectory.position[1, 0] == pytest.approx(start, abs=1e-13)
    assert abs(trajectory.velocity[1, 0]).max() < 1e-12


@pytest.mark.parametrize(("y", "force"), [(1.0, -2 * 9.8125), (-1.0, 2 * 9.8125)])
def test_at_rest_at_the_top_or_the_bottom_it_stays_to_the_last_bit(solved, y, force):
    trajectory = solved(
        hanging((0.0, y, 0.0), (0.0, 0.0, 0.0), mass=2.0), 1e6 * PARTS, "exact-pendulum"
    )
    assert np.array_equal(trajectory.position[:, 0], np.tile((0.0, y, 0.0), (6, 1)))
    assert not trajectory.velocity.any()
    assert np.array_equal(trajectory.channels["rod_force"][:, 0], np.full(6, force))


def test_fall_from_next_to_the_top_takes_the_logarithmic_time(solved):
    # From rest at pi - d: cos(theta/2) = sin(d/2) nd(w0 t); it passes the bottom after K =
    # ln(4/sin(d/2)).
    d = 1e-8
    g = 9.8125
    fall = np.log(4.0 / np.sin(d / 2)) / np.sqrt(g)
    trajectory = solved(
        hanging((np.sin(d), np.cos(d), 0.0), (0.0, 0.0, 0.0)), (0.0, fall), "exact-pendulum"
    )
    assert trajectory.position[1, 0] == pytest.approx([0.0, -1.0, 0.0], abs=1e-13)


def test_without_gravity_the_point_goes_round_evenly(solved):
    trajectory = solved(
        hanging((0.0, 2.0, 0.0), (0.0, 0.0, 3.0), g=(0.0, 0.0, 0.0), length=2.0),
        (0.0, 1.0, 1e5),
        "exact-pendulum",
    )
    angle = 1.5 * trajectory.t
    expected = np.stack([0 * angle, 2 * np.cos(angle), 2 * np.sin(angle)], axis=1)
    assert trajectory.position[:, 0] == pytest.approx(expected, abs=1e-15)
    assert trajectory.channels["rod_force"][:, 0] == pytest.approx([4.5] * 3, abs=1e-14)


def test_any_plane_that_holds_gravity_shows_the_same_motion(solved):
    # The same swing in the plane spanned by -z (down) and (3/5, 4/5, 0), about another anchor.
    flat = solved(hanging((0.0, -1.0, 0.0), (3.0, 0.0, 0.0)), 7 * PARTS, "exact-pendulum")
    anchor = (2.0, -1.0, 0.5)
    tilted = solved(
        hanging((0.0, 0.0, -1.0), (1.8, 2.4, 0.0), g=(0.0, 0.0, -9.8125), anchor=anchor),
        7 * PARTS,
        "exact-pendulum",
    )
    x = flat.position[:, 0, 0]
    y = flat.position[:, 0, 1]
    assert tilted.position[:, 0] - anchor == pytest.approx(
        np.stack([0.6 * x, 0.8 * x, y], axis=1), abs=4e-14
    )
    assert tilted.channels["rod_force"] == pytest.approx(flat.channels["rod_force"], abs=4e-13)


def test_motion_with_its_velocity_turned_round_is_the_motion_backwards(solved):
    forward = solved(hanging((0.6, -0.8, 0.0), (0.8, 0.6, 0.0)), (0.0, 11.0), "exact-pendulum")
    backward = solved(hanging((0.6, -0.8, 0.0), (-0.8, -0.6, 0.0)), (0.0, -11.0), "exact-pendulum")
    assert forward.position[1] == pytest.approx(backward.position[1], abs=4e-15)
    assert forward.velocity[1] == pytest.approx(-backward.velocity[1], abs=2e-14)


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (hanging((0.0, -1.0, 0.0), (0.5, 0.0, 0.5)), None),
        (hanging((0.6, -0.8, 0.0), (0.0, 0.0, 0.5)), "spherical"),
        (hanging((0.6, -0.8, 0.0), (0.6, -0.8, 0.0)), "along the rod"),
        (hanging((0.6, -0.8, 0.0), (0.0, 0.0, 0.0), length=1.5), "starts 1.0 long"),
        (Scene.of([Body(mass=1.0)]), "no elements of kind rod"),
        (
            Scene.of(
                [Body(mass=1.0), Body(mass=1.0, position=(1.0, 0.0, 0.0))],
                [Rod(a=0, b=1, length=1.0)],
            ),
            "2 bodies",
        ),
    ],
)
def test_motion_that_is_no_plane_pendulum_is_refused(scene, reason):
    unsupported = ENGINE.unsupported_motion(
        Motion(scene, np.array([0.0, 1.0])), ENGINE.method("exact-pendulum")
    )
    assert unsupported is None if reason is None else reason in str(unsupported)
