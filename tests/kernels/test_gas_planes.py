"""The kernel of many spheres at walls that rub: against the method for two, from a start within the
contact, into one, and over lists that are rebuilt.
"""

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane

Vector = tuple[float, float, float]
STEP = 2.0**-10
SIZE = 20.0
WALLS = [
    Plane(point=point, normal=normal)
    for point, normal in (
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((SIZE, 0.0, 0.0), (-1.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, SIZE, 0.0), (0.0, -1.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        ((0.0, 0.0, SIZE), (0.0, 0.0, -1.0)),
    )
]


def sphere(position: Vector, velocity: Vector, omega: Vector = (0.0, 0.0, 0.0)) -> Body:
    return Body(
        mass=1.0,
        inertia=(0.1,) * 3,
        shape=Sphere(radius=0.5),
        position=position,
        velocity=velocity,
        omega=omega,
    )


def moved(bodies: list[Body], law: Contact, method: str) -> Trajectory:
    """The spheres between six walls."""
    times = np.arange(33) * 2 * STEP
    problem = Motion(Scene.of(bodies, [law, *WALLS]), times)
    run, _ = ENGINE.run(Request(problem=problem, method=method, step=STEP))
    return run


@pytest.mark.parametrize("wall", range(3))
@pytest.mark.parametrize("is_far", [False, True])
@pytest.mark.parametrize("friction", [0.2, 5.0], ids=["slides", "sticks"])
@pytest.mark.parametrize("hurries", [False, True])
@pytest.mark.parametrize("overlap", [0.01, 0.0])
def test_a_sphere_at_a_wall_moves_as_the_method_for_two_has_it(
    wall: int, is_far: bool, friction: float, hurries: bool, overlap: float
) -> None:
    """Where it overlaps at the start its spring is slack, and no contact has begun. Another is so
    fast that the list is rebuilt every few steps.
    """
    law = Contact(law="linear", stiffness=1000.0, tangential_stiffness=300.0, friction=friction)
    place = np.full(3, SIZE / 2)
    velocity = np.array([0.35, -0.25, 0.15])
    side = 1.0
    place[wall] = 0.5 - overlap
    if is_far:
        side = -1.0
        place[wall] = SIZE - 0.5 + overlap
    velocity[wall] = -0.2 * side
    own = sphere(tuple(place.tolist()), tuple(velocity.tolist()), (0.1, 0.2, 0.3))
    others = [sphere((3.0, 14.0, 15.0), (-1.0, 0.5, 0.25))]
    if hurries:
        others.append(sphere((15.0, 15.0, 14.0), (40.0, 30.0, -50.0)))
    few = moved([own], law, "velocity-verlet")
    many = moved([*others, own], law, "gas")
    assert np.ptp(few.velocity[:, 0, wall]) > 0.05
    assert np.ptp(few.omega[:, 0, (wall + 1) % 3]) > 0.01
    # The method for two cuts the step in which a touch or a slip begins; the gas does not.
    allowed = 1e-3
    if overlap and friction > 1:
        allowed = 1e-10
    for name in ("position", "velocity", "omega", "attitude"):
        there = getattr(many, name)[:, len(others)]
        assert np.abs(there - getattr(few, name)[:, 0]).max() < allowed, name
    begun = [event.time for event in many.events if event.body == len(others)]
    assert begun == ([] if overlap else begun[:1])
