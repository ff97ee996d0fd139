"""What contact does to angular momentum in Chipmunk: it is not kept to round-off, with friction or
without, and is not claimed.
"""

import numpy as np
import pytest

from refdem.core.balance import angular, linear
from refdem.engines.pymunk import ENGINE
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.spring import Spring

METHOD = ENGINE.methods[0]


def meeting(friction):
    """Two discs that spin and meet off centre."""
    first = Body(
        mass=1.0,
        inertia=(0.1,) * 3,
        position=(-1.0, 0.3, 0.0),
        velocity=(1.0, 0.1, 0.0),
        omega=(0, 0, 2.0),
        shape=Sphere(radius=0.5),
    )
    other = Body(
        mass=2.0,
        inertia=(0.3,) * 3,
        position=(1.0, 0.0, 0.0),
        velocity=(-0.7, 0.0, 0.0),
        omega=(0, 0, 0.5),
        shape=Sphere(radius=0.6),
    )
    return Scene.of([first, other], [Contact(law="rigid", restitution=0.5, friction=friction)])


def change(scene, found):
    total = angular(scene, found)["total"]
    return float(np.max(np.abs(total - total[0])))


@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0])
def test_a_contact_changes_angular_momentum_in_proportion_to_the_overlap_and_keeps_momentum(
    run, friction
):
    scene = meeting(friction)
    coarse, fine = (run(scene, 2.0, 32, step) for step in (2.0**-6, 2.0**-12))
    momentum = linear(scene, coarse)
    assert np.max(np.abs(momentum - momentum[0])) < 1e-13
    assert change(scene, coarse) > 1e-4
    assert change(scene, fine) < 0.1 * change(scene, coarse)


def test_angular_momentum_is_claimed_without_contact_and_not_with_it():
    assert not METHOD.keeps("angular-momentum", meeting(0.3).features)
    assert not METHOD.keeps("angular-momentum", meeting(0.0).features)
    assert METHOD.keeps("momentum", meeting(0.3).features)


def test_a_spring_between_two_bodies_keeps_it_as_claimed(run):
    bodies = [
        Body(mass=1.0, position=(-1.0, 0.2, 0.0), velocity=(0.1, 0.4, 0.0)),
        Body(mass=2.0, position=(1.0, 0.0, 0.0)),
    ]
    scene = Scene.of(bodies, [Spring(a=0, b=1, stiffness=3.0, length=1.0)])
    assert METHOD.keeps("angular-momentum", scene.features)
    assert change(scene, run(scene, 2.0, 32, 2.0**-8)) < 1e-13
