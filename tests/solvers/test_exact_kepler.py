"""Kepler orbits in closed form: against certified truth, and what an orbit keeps."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.central_field import CentralField


def orbiting(position, velocity, gm):
    """A point about the origin."""
    return Scene.of(
        [Body(mass=1.0, position=tuple(position), velocity=tuple(velocity))], [CentralField(gm=gm)]
    )


@pytest.mark.parametrize("speed", [1, 2, 3, 4, 14, 100])
@pytest.mark.parametrize("orbits", [1, -100])
def test_state_is_right_to_some_ulps_after_many_orbits_of_any_eccentricity(
    solved, largest_error, speed, orbits
):
    # Periapsis at 1 m with a whole speed k: gm = a = (k^2 + 1)/2 and e = (k^2 - 1)/(k^2 + 1) are
    # exact, up to e = 0.9998.
    a = Fraction(speed**2 + 1, 2)
    e = Fraction(speed**2 - 1, speed**2 + 1)
    given = {"gm": str(a), "semi_major": str(a), "eccentricity": str(e)}
    t = np.array([0.0, 1e-4, 0.01, 0.3, 0.5, 0.9999, 1.0]) * orbits * 2 * np.pi * float(a)
    trajectory = solved(
        orbiting((1.0, 0.0, 0.0), (0.0, float(speed), 0.0), float(a)), t, "exact-kepler"
    )
    assert largest_error("two-body-orbit", trajectory, ("x", "y", "vx", "vy"), **given) < 3e-15


def test_energy_angular_momentum_and_laplace_vector_stay_on_a_tilted_orbit(solved):
    r = np.array((1.0, -2.0, 0.5))
    v = np.array((0.25, 0.5, -0.25))
    gm = 2.0
    trajectory = solved(orbiting(r, v, gm), np.linspace(0.0, 500.0, 60), "exact-kepler")
    x = trajectory.position[:, 0]
    u = trajectory.velocity[:, 0]
    size = np.linalg.norm(x, axis=1)
    moment = np.cross(x, u)
    laplace = np.cross(u, moment) / gm - x / size[:, None]
    assert moment == pytest.approx(np.tile(np.cross(r, v), (60, 1)), abs=5e-15)
    assert np.sum(u * u, axis=1) / 2 - gm / size == pytest.approx(
        np.full(60, v @ v / 2 - gm / np.linalg.norm(r)), abs=3e-14
    )
    assert laplace == pytest.approx(np.tile(laplace[0], (60, 1)), abs=2e-14)


def test_orbit_from_anywhere_returns_after_its_period(solved):
    r = np.array((1.0, -2.0, 0.5))
    v = np.array((0.25, 0.5, -0.25))
    gm = 2.0
    a = 1 / (2 / np.linalg.norm(r) - v @ v / gm)
    period = 2 * np.pi * np.sqrt(a**3 / gm)
    trajectory = solved(orbiting(r, v, gm), (0.0, period / 2, period), "exact-kepler")
    assert trajectory.position[2, 0] == pytest.approx(r, abs=2e-14)
    assert trajectory.velocity[2, 0] == pytest.approx(v, abs=2e-14)
    assert np.linalg.norm(trajectory.position[1, 0] - r) > 1.0


def test_motion_with_its_velocity_turned_round_is_the_motion_backwards(solved):
    forward = solved(orbiting((1.0, 0.5, 0.0), (0.25, 1.0, 0.0), 1.0), (0.0, 40.0), "exact-kepler")
    backward = solved(
        orbiting((1.0, 0.5, 0.0), (-0.25, -1.0, 0.0), 1.0), (0.0, -40.0), "exact-kepler"
    )
    assert forward.position[1] == pytest.approx(backward.position[1], abs=1e-14)
    assert forward.velocity[1] == pytest.approx(-backward.velocity[1], abs=1e-14)


@pytest.mark.parametrize(
    ("velocity", "reason"),
    [
        ((0.0, 1.4, 0.0), None),
        ((0.0, 1.5, 0.0), "not bound"),
        ((0.5, 0.0, 0.0), "through the centre"),
        ((0.0, 0.0, 0.0), "through the centre"),
    ],
)
def test_orbits_that_never_return_or_meet_the_centre_are_refused(velocity, reason):
    problem = Motion(orbiting((1.0, 0.0, 0.0), velocity, 1.0), np.array([0.0, 1.0]))
    unsupported = ENGINE.unsupported_motion(problem, ENGINE.method("exact-kepler"))
    assert unsupported is None if reason is None else reason in str(unsupported)
