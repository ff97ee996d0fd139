"""RATTLE: rods in position and velocity, order, drift and reversal, and systems whose motion is
known otherwise.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.errors import EngineError
from refdem.mechanics.momentum import linear, orbital
from refdem.mechanics.quaternion import rotated
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

GRAVITY = UniformGravity(g=(0.0, -9.8125, 0.0))
GIVEN = {"theta0": "0", "thetadot0": "5"}


@pytest.fixture
def pendulum():
    return discovery.case("pendulum").at(**GIVEN).scene


def cluster():
    """Four masses on six rods, spinning: inertia (2 b^2 + 4 c^2, 2 a^2 + 4 c^2, 2 a^2 + 2 b^2) for
    masses of 1 kg.
    """
    a = 0.5
    b = 0.75
    c = 0.25
    places = np.array([(a, 0, -c), (-a, 0, -c), (0, b, c), (0, -b, c)])
    omega = np.array((0.9, 1.1, 1.3))
    bodies = [Body(mass=1.0, position=tuple(r), velocity=tuple(np.cross(omega, r))) for r in places]
    pairs = [(i, j) for i in range(4) for j in range(i)]
    rods = [Rod(a=i, b=j, length=float(np.linalg.norm(places[i] - places[j]))) for i, j in pairs]
    inertia = (2 * b * b + 4 * c * c, 2 * a * a + 4 * c * c, 2 * a * a + 2 * b * b)
    return Scene.of(bodies, rods), Body(mass=4.0, inertia=inertia, omega=tuple(omega)), places


def test_error_falls_with_order_two_in_place_and_rod_force(solved, largest_error, pendulum):
    for names in (("x", "y", "thetadot"), ("rod_force",)):
        runs = [solved(pendulum, np.arange(9) * 0.5, "rattle", 2.0**-k) for k in (8, 9, 10, 11)]
        errors = [largest_error("pendulum", run, names, **GIVEN) for run in runs]
        assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2.0, abs=0.05)


def test_rods_keep_length_and_velocity_stays_across_them_over_1e5_steps(solved, pendulum):
    trajectory = solved(pendulum, np.arange(201) * 4.0, "rattle", 2.0**-7)
    r = trajectory.position[:, 0]
    v = trajectory.velocity[:, 0]
    assert np.abs(np.linalg.norm(r, axis=1) - 1.0).max() < 3e-15
    assert np.abs(np.sum(r * v, axis=1)).max() < 5e-15


def test_round_off_of_a_million_steps_does_not_hide_the_order(solved, largest_error, pendulum):
    # The errors are 5e-11 and 1e-11; sums that lose their low parts are off by 1 % of them.
    errors = [
        largest_error(
            "pendulum", solved(pendulum, (0.0, 4.0), "rattle", 2.0**-k), ("x", "y"), **GIVEN
        )
        for k in (18, 19)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=1e-4)


@pytest.mark.parametrize("y", [1.0, -1.0])
def test_at_rest_at_the_top_or_the_bottom_it_stays_to_the_last_bit(solved, y):
    scene = Scene.of([Body(mass=1.0, position=(0.0, y, 0.0))], [Rod(a=0, length=1.0), GRAVITY])
    trajectory = solved(scene, (0.0, 100.0, 200.0), "rattle", 2.0**-6)
    assert np.array_equal(trajectory.position[:, 0], np.tile((0.0, y, 0.0), (3, 1)))
    assert not trajectory.velocity.any()
    assert np.array_equal(trajectory.channels["rod_force"], np.full((3, 1), -9.8125 * y))


def test_energy_has_no_drift(solved, pendulum):
    trajectory = solved(pendulum, np.arange(2001) * 0.5, "rattle", 2.0**-6)
    energy = np.sum(trajectory.velocity**2, axis=(1, 2)) / 2 + 9.8125 * trajectory.position[:, 0, 1]
    off = np.abs(energy - energy[0])
    assert off[1001:].max() < 1.05 * off[:1001].max() < 0.1


def test_run_back_by_negative_steps_or_turned_velocity_returns(solved, pendulum):
    there = solved(pendulum, (0.0, 4.0, 8.0), "rattle", 2.0**-7)
    end = pendulum.with_state(**there.end())
    turned = pendulum.with_state(position=there.position[-1], velocity=-there.velocity[-1])
    for back, sign in (
        (solved(end, (8.0, 4.0, 0.0), "rattle", 2.0**-7), 1),
        (solved(turned, (0.0, 4.0, 8.0), "rattle", 2.0**-7), -1),
    ):
        assert back.position == pytest.approx(there.position[::-1], abs=1e-12)
        assert back.velocity == pytest.approx(sign * there.velocity[::-1], abs=1e-11)


def test_rod_force_is_tension_and_that_of_the_state(solved):
    # At the bottom with speed v: m (v^2/l + g); two equal masses that turn about each other: (m/2)
    # w^2 L; hung at rest: m g.
    body = Body(mass=2.0, position=(0.0, -4.0, 0.0), velocity=(3.0, 0.0, 0.0))
    swing = solved(Scene.of([body], [Rod(a=0, length=4.0), GRAVITY]), (0.0, 0.25), "rattle", 0.25)
    assert swing.channels["rod_force"][0] == pytest.approx([2.0 * (9.0 / 4.0 + 9.8125)], rel=1e-15)
    pair = [Body(mass=1.0, position=(x, 0.0, 0.0), velocity=(0.0, 3 * x, 0.0)) for x in (1.0, -1.0)]
    turn = solved(Scene.of(pair, [Rod(a=0, b=1, length=2.0)]), (0.0, 1.0, 2.0), "rattle", 2.0**-12)
    assert turn.channels["rod_force"] == pytest.approx(np.full((3, 1), 9.0), abs=1e-5)


def test_rigid_cluster_turns_like_the_free_rigid_body(solved):
    scene, body, places = cluster()
    held = solved(scene, (0.0, 2.0, 4.0), "rattle", 2.0**-10)
    free = solved(Scene.of([body]), (0.0, 2.0, 4.0), "exact-free-body")
    expected = rotated(free.attitude, places[None])
    assert held.position == pytest.approx(expected, abs=2e-5)
    finer = solved(scene, (0.0, 2.0, 4.0), "rattle", 2.0**-11)
    ratio = np.abs(held.position - expected).max() / np.abs(finer.position - expected).max()
    assert ratio == pytest.approx(4.0, abs=0.05)


def test_isolated_rods_keep_momentum_and_angular_momentum(solved):
    scene, _, _ = cluster()
    moving = scene.with_state(velocity=scene.bodies.velocity + np.array((0.5, -0.25, 1.0)))
    trajectory = solved(moving, np.arange(5) * 4.0, "rattle", 2.0**-6)
    mass = scene.bodies.mass
    momentum = linear(mass, trajectory.velocity)
    moment = orbital(mass, trajectory.position, trajectory.velocity)
    assert momentum == pytest.approx(np.tile(momentum[0], (5, 1)), abs=1e-13)
    # The centre is 16 m from the origin at the end, where an ulp of the velocity is one of 16 m in
    # the moment.
    assert moment == pytest.approx(np.tile(moment[0], (5, 1)), abs=1e-12)


def test_a_rod_given_twice_changes_nothing_but_shares_the_force(solved):
    scene, _, _ = cluster()
    doubled = Scene(scene.bodies, (*scene.elements, scene.elements[0]))
    once, twice = (solved(s, (0.0, 1.0, 2.0), "rattle", 2.0**-7) for s in (scene, doubled))
    assert twice.position == pytest.approx(once.position, abs=1e-12)
    force = twice.channels["rod_force"]
    assert force[:, 0] + force[:, 6] == pytest.approx(once.channels["rod_force"][:, 0], abs=1e-11)


def test_fixed_body_holds_like_the_world(solved):
    free = Body(mass=1.0, position=(0.5, -1.0, 0.0))
    post = Body(mass=1.0, position=(0.5, 0.0, 0.0), fixed=True)
    world = solved(
        Scene.of([free], [Rod(a=0, anchor_b=(0.5, 0.0, 0.0), length=1.0), GRAVITY]),
        (0.0, 1.0, 2.0),
        "rattle",
        2.0**-7,
    )
    fixed = solved(
        Scene.of([free, post], [Rod(a=0, b=1, length=1.0), GRAVITY]),
        (0.0, 1.0, 2.0),
        "rattle",
        2.0**-7,
    )
    assert np.array_equal(world.position[:, 0], fixed.position[:, 0])
    assert np.array_equal(fixed.position[:, 1], np.tile((0.5, 0.0, 0.0), (3, 1)))


def test_centre_of_two_joined_masses_on_equal_springs_is_harmonic(solved):
    bodies = [Body(mass=1.0, position=(x, 0.5, 0.0), velocity=(0.0, x, 0.0)) for x in (1.0, -1.0)]
    elements = [
        Rod(a=0, b=1, length=2.0),
        Spring(a=0, stiffness=4.0),
        Spring(a=1, stiffness=4.0),
        GRAVITY,
    ]
    times = np.arange(5) * 0.5
    centre = Scene.of(
        [Body(mass=2.0, position=(0.0, 0.5, 0.0))], [Spring(a=0, stiffness=8.0), GRAVITY]
    )
    expected = solved(centre, times, "exact-harmonic").position[:, 0]
    held = solved(Scene.of(bodies, elements), times, "rattle", 2.0**-12).position.mean(axis=1)
    assert held == pytest.approx(expected, abs=1e-6)


def test_bent_spring_law_acts_along_the_stretch(solved):
    # Energy with a spring of natural length 3/2 and exponent 3/2 goes from the spring into the mass
    # and back.
    body = Body(mass=1.0, position=(0.0, -1.0, 0.0))
    scene = Scene.of(
        [body],
        [
            Rod(a=0, length=1.0),
            Spring(a=0, stiffness=30.0, length=1.5, exponent=1.5, anchor_b=(2.0, 0.0, 0.0)),
        ],
    )
    trajectory = solved(scene, np.arange(41) * 0.125, "rattle", 2.0**-12)
    energy = np.sum(trajectory.velocity**2, axis=(1, 2)) / 2 + scene.potential(
        trajectory.position, trajectory.attitude
    )
    assert energy == pytest.approx(np.full(41, energy[0]), abs=1e-5)
    assert np.ptp(trajectory.position[:, 0, 0]) > 0.5


def test_step_that_no_multiplier_can_hold_is_an_error_of_the_run(solved, pendulum):
    with pytest.raises(EngineError, match="take a smaller one"):
        solved(pendulum, (0.0, 4.0), "rattle", 4.0)


HUNG = Body(mass=1.0, position=(1.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (Scene.of([Body(mass=1.0)], [GRAVITY]), "no elements of kind rod"),
        (
            Scene.of(
                [Body(mass=1.0, position=(1.0, 0.0, 0.0))],
                [Rod(a=0, length=1.0), Slider(a=0, friction=0.5, normal_force=1.0)],
            ),
            "of kind slider; expected only rod",
        ),
        (
            Scene.of(
                [Body(mass=1.0, inertia=(1.0, 1.0, 1.0), omega=(0.0, 0.0, 1.0))],
                [Rod(a=0, length=1.0)],
            ),
            "rotation",
        ),
        (
            Scene.of([HUNG], [Rod(a=0, length=1.0), Spring(a=0, stiffness=1.0, quadratic=0.5)]),
            "a square or a cube",
        ),
        (
            Scene.of([HUNG], [Rod(a=0, length=1.0), Spring(a=0, stiffness=1.0, cubic=0.5)]),
            "a square or a cube",
        ),
    ],
)
def test_scene_that_is_more_than_points_on_rods_is_refused(scene, reason):
    assert reason in str(
        ENGINE.unsupported_motion(Motion(scene, np.array([0.0, 1.0])), ENGINE.method("rattle"))
    )
