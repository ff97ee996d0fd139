"""A point on a rod in Cartesian coordinates: truth in the plane, a cone and a symmetry in space,
drift, reversal, refusals.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

G = 9.8125
NAMES = ("x", "y", "thetadot", "rod_force")


def hanging(position, velocity, length=1.0, gravity=(0.0, -G, 0.0), anchor=(0.0, 0.0, 0.0)):
    bodies = [Body(mass=2.0, position=tuple(position), velocity=tuple(velocity))]
    return Scene.of(
        bodies,
        [Rod(a=0, b=-1, length=length, anchor_b=tuple(anchor)), UniformGravity(g=tuple(gravity))],
    )


def coned(angle):
    """A conical pendulum: rate^2 = g/(l cos angle)."""
    return hanging(
        (np.sin(angle), -np.cos(angle), 0.0), (0.0, 0.0, np.sin(angle) * np.sqrt(G / np.cos(angle)))
    )


@pytest.mark.parametrize("theta0", ["1", "3", "-2.5"])
def test_motion_in_the_plane_is_right_to_some_ulps_of_what_a_start_so_near_the_top_makes_of_them(
    solved, largest_error, theta0
):
    grown = 1 / np.cos(float(theta0) / 2)
    scene = discovery.case("pendulum").at(theta0=theta0).scene
    for times in ((0.0, 0.25, 3.0, 7.0), (0.0, -0.25, -7.0)):
        assert (
            largest_error("pendulum", solved(scene, times, "rod-taylor"), NAMES, theta0=theta0)
            < 5e-14 * grown
        )


def test_a_cone_is_gone_round_at_its_own_rate(solved):
    angle = 0.75
    t = np.linspace(0.0, 20.0, 41)
    run = solved(coned(angle), t, "rod-taylor")
    rate = np.sqrt(G / np.cos(angle))
    way = np.stack(
        [
            np.sin(angle) * np.cos(rate * t),
            np.full(41, -np.cos(angle)),
            np.sin(angle) * np.sin(rate * t),
        ],
        axis=-1,
    )
    assert np.abs(run.position[:, 0] - way).max() < 3e-13
    assert run.channels["rod_force"] == pytest.approx(2.0 * G / np.cos(angle), rel=1e-13)


def test_rod_energy_and_moment_are_held_for_a_thousand_swings_in_space(solved):
    start = np.array((0.6, -0.8, 0.0))
    push = np.array((0.4, 0.3, 1.5))
    run = solved(hanging(start, push), np.linspace(0.0, 2000.0, 2001), "rod-taylor")
    r = run.position[:, 0]
    v = run.velocity[:, 0]
    energy = np.sum(v * v, axis=1) / 2 + G * r[:, 1]
    moment = np.cross(r, v)[:, 1]
    assert np.abs(np.linalg.norm(r, axis=1) - 1.0).max() < 2e-15
    assert np.abs(np.sum(r * v, axis=1)).max() < 5e-15
    assert np.abs(energy - energy[0]).max() < 1e-13 * G
    assert np.abs(moment - moment[0]).max() < 1e-13


@pytest.mark.parametrize("delta", ["1e-3", "1e-7", "1e-8", "1e-10"])
def test_a_slow_start_next_to_the_top_keeps_the_rod_too(solved, delta):
    t = np.linspace(0.0, 4.0, 401)
    run = solved(discovery.case("pendulum-equilibria").at(delta=delta).scene, t, "rod-taylor")
    r = run.position[:, 0]
    v = run.velocity[:, 0]
    assert (
        np.abs(np.linalg.norm(r, axis=1) - 1.0).max() < 2e-15
    )  # 2.5e-14 with steps as long as the series alone allow
    assert np.abs(np.sum(r * v, axis=1)).max() < 2e-14


def test_time_runs_backwards_to_where_it_began(solved):
    scene = hanging((0.6, -0.8, 0.0), (0.4, 0.3, 1.5))
    there = solved(scene, (0.0, 30.0), "rod-taylor")
    back = solved(
        scene.with_state(position=there.position[-1], velocity=there.velocity[-1]),
        (30.0, 0.0),
        "rod-taylor",
    )
    assert np.abs(back.position[-1] - scene.bodies.position).max() < 1e-12
    assert np.abs(back.velocity[-1] - scene.bodies.velocity).max() < 1e-12


def test_length_anchor_and_direction_of_gravity_are_free(solved):
    plain = solved(hanging((0.6, -0.8, 0.0), (0.4, 0.3, 1.5)), (0.0, 1.0, 5.0), "rod-taylor")
    turned = hanging(
        (2.0, 1.2, -1.6 + 3),
        (3.0, 0.8, 0.6),
        length=2.0,
        gravity=(0.0, 0.0, -2 * G),
        anchor=(2.0, 0.0, 3.0),
    )
    run = solved(turned, (0.0, 1.0, 5.0), "rod-taylor")
    assert run.position[:, 0] - np.array((2.0, 0.0, 3.0)) == pytest.approx(
        2 * plain.position[:, 0][:, [2, 0, 1]], abs=1e-12
    )
    assert run.channels["rod_force"] == pytest.approx(2 * plain.channels["rod_force"], rel=1e-12)


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (hanging((0.6, -0.8, 0.0), (0.6, -0.8, 0.0)), "speed along the rod"),
        (hanging((0.6, -0.9, 0.0), (0.0, 0.0, 0.0)), "long"),
        (Scene.of([Body(mass=1.0)], [UniformGravity(g=(0.0, -G, 0.0))]), "no elements of kind rod"),
    ],
)
def test_what_no_rigid_rod_does_is_refused(scene, reason):
    assert reason in ENGINE.unsupported_motion(
        Motion(scene, np.array([0.0, 1.0])), ENGINE.method("rod-taylor")
    )
