"""Points on rods as one rigid body: certified truth, RATTLE's forces, a dumb-bell cross by hand,
redundant rods, refusals.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

ULP = np.finfo(float).eps
T = np.linspace(0.0, 2.0, 5)
TETRAHEDRON = {"masses": "1,1,1,1", "positions": "1,1,1,1,-1,-1,-1,1,-1,-1,-1,1"}
SETS = [
    {},
    TETRAHEDRON,
    {"masses": "1e-3,7,3,100", "positions": "3,1,4,1,5,9,2,6,5,3,5,8", "omega": "-3,1,40"},
]
QUANTITIES = tuple(f"r{i}.{axis}" for i in range(1, 5) for axis in "xyz")


def cluster(**given):
    return discovery.case("rigid-cluster").at(**given).scene


@pytest.mark.parametrize("given", SETS)
def test_places_are_right_to_round_off(solved, largest_error, given):
    # The rate of turning comes from rounded moments of inertia: its error grows with the angle that
    # the body has turned.
    omega = [float(Fraction(part)) for part in given.get("omega", "1/2,1,-1/4").split(",")]
    angle = float(np.linalg.norm(omega)) * T[-1]
    bound = 40 * ULP * (1 + angle)
    run = solved(cluster(**given), T, "exact-rigid-cluster")
    assert largest_error("rigid-cluster", run, QUANTITIES, **given) < bound


def test_motion_and_forces_are_what_rattle_tends_to(solved):
    exact = solved(cluster(), T, "exact-rigid-cluster")
    errors = []
    for steps in (128, 256):
        run = solved(cluster(), T, "rattle", T[1] / steps)
        errors.append(
            [
                np.abs(getattr(run, name) - getattr(exact, name)).max()
                for name in ("position", "velocity")
            ]
        )
        errors[-1].append(np.abs(run.channels["rod_force"] - exact.channels["rod_force"]).max())
    assert np.divide(*errors) == pytest.approx([4.0] * 3, rel=0.02)


def test_edges_of_a_spinning_tetrahedron_carry_what_keeps_its_corners_on_their_circles(solved):
    # About z at rate w: z stays, so the edges across (length 2 sqrt 2, horizontal) hold m w^2 r =
    # sqrt 2 each end, the four others nothing.
    scene = cluster(**TETRAHEDRON, omega="0,0,1")
    force = solved(scene, T, "exact-rigid-cluster").channels["rod_force"]
    flat = [
        abs(scene.bodies.position[rod.a, 2] - scene.bodies.position[rod.b, 2]) == 0
        for rod in scene.all(Rod)
    ]
    assert force == pytest.approx(np.tile(np.where(flat, np.sqrt(2.0), 0.0), (5, 1)), abs=2e-14)


def test_a_rod_twice_shares_its_force(solved):
    scene = cluster()
    double = Scene(scene.bodies, (*scene.elements, scene.elements[0]))
    plain, shared = (
        solved(s, T, "exact-rigid-cluster").channels["rod_force"] for s in (scene, double)
    )
    assert shared[:, 0] == pytest.approx(plain[:, 0] / 2, rel=1e-10)
    assert shared[:, 6] == pytest.approx(plain[:, 0] / 2, rel=1e-10)


def test_a_cluster_in_flight_takes_its_motion_with_it(solved):
    scene = cluster()
    drift = np.array([3.0, -1.0, 0.5])
    still = solved(scene, T, "exact-rigid-cluster")
    moved = solved(
        scene.with_state(velocity=scene.bodies.velocity + drift), T, "exact-rigid-cluster"
    )
    assert moved.position == pytest.approx(still.position + np.outer(T, drift)[:, None], abs=1e-13)


SCENE = cluster()


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (SCENE, None),
        (Scene(SCENE.bodies, SCENE.elements[1:]), "one rigid body"),
        (
            Scene(SCENE.bodies, (*SCENE.elements, UniformGravity(g=(0.0, 0.0, -1.0)))),
            "uniform_gravity",
        ),
        (Scene(SCENE.bodies, (*SCENE.elements, Rod(a=0, length=1.0))), "to the world"),
        (SCENE.with_state(position=SCENE.bodies.position * 1.1), "long"),
        (SCENE.with_state(velocity=SCENE.bodies.position), "speed along"),
        (Scene(SCENE.bodies, ()), "no elements of kind rod"),
    ],
)
def test_what_is_no_rigid_body_is_refused(scene, reason):
    unsupported = ENGINE.unsupported_motion(Motion(scene, T), ENGINE.method("exact-rigid-cluster"))
    assert unsupported is None if reason is None else reason in str(unsupported)
