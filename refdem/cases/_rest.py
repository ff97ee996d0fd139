"""The scenes of Newton's first law: a free body, a block, a stack of two, and two spheres.

All numbers are dyadic, so that every balance of forces is exact in binary64.
"""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.quantity import Scales
from refdem.scene import Body, Scene, Sphere, box
from refdem.scene.element import Element
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
GRAVITY = Fraction(157, 16)
"""m/s^2: near the Earth's, and dyadic."""
MASS = Fraction(3)
SIDES = (1.0, 1.0, 0.5)
HEIGHT = Fraction(1, 2)
"""The third of the sides."""
BLOCK_INERTIA = (0.3125, 0.3125, 0.5)
"""m/12 times the sums of squares of two sides."""
BALL_MASS = Fraction(5)
RADIUS = Fraction(1, 2)
STIFFNESS = Fraction(8192)


def free(velocity: Array, spin: float) -> Scene:
    """A body with three different moments that flies with `velocity` (3,) [m/s] and spins about its
    third axis [rad/s].
    """
    return Scene.of(
        [Body(mass=1.0, inertia=(0.5, 0.75, 1.0), velocity=tuple(velocity), omega=(0.0, 0.0, spin))]
    )


def _ground(contact: Contact) -> tuple[Element, ...]:
    """The ground z = 0, gravity along -z, and the contact law."""
    return Plane(), UniformGravity(g=(0.0, 0.0, -float(GRAVITY))), contact


def heights(member: str) -> list[Fraction]:
    """The heights [m] of the centres of a member's bodies above the ground."""
    if member == "spheres":
        # Each contact is compressed by the weight above it over the stiffness.
        compression = BALL_MASS * GRAVITY / STIFFNESS
        low = RADIUS - 2 * compression
        return [low, low + 2 * RADIUS - compression]
    return [(i + Fraction(1, 2)) * HEIGHT for i in range(BLOCKS[member])]


def _blocks(member: str) -> Scene:
    """Boxes exactly on top of each other, the lowest on the ground."""
    bodies = [
        Body(
            mass=float(MASS),
            inertia=BLOCK_INERTIA,
            position=(0.0, 0.0, float(z)),
            shape=box(*SIDES),
        )
        for z in heights(member)
    ]
    return Scene.of(bodies, _ground(Contact(law="rigid", friction=0.5)))


def block() -> Scene:
    """The scene of one block at rest on the ground."""
    return _blocks("block")


def stack() -> Scene:
    """The scene of two blocks at rest, one on the other."""
    return _blocks("stack")


def spheres() -> Scene:
    """Two spheres, one on the other, each contact compressed by the weight above it over the
    stiffness.
    """
    mass = float(BALL_MASS)
    radius = float(RADIUS)
    inertia = 0.4 * mass * radius**2
    bodies = [
        Body(
            mass=mass,
            inertia=(inertia,) * 3,
            position=(0.0, 0.0, float(z)),
            shape=Sphere(radius=radius),
        )
        for z in heights("spheres")
    ]
    return Scene.of(bodies, _ground(Contact(law="linear", stiffness=float(STIFFNESS))))


def balance(member: str) -> dict[str, Any]:
    """The exact numbers of the balance of bodies on each other, with which a witness starts.

    `weight` of each [N], `stiffness` of the contacts [N/m] (0: rigid), `heights` of the centres
    [m], and `sizes`: the distances [m] below which a body touches the one below it, the ground
    first.
    """
    centres = heights(member)
    if member == "spheres":
        half = RADIUS
        mass = BALL_MASS
        stiffness = STIFFNESS
    else:
        half = HEIGHT / 2
        mass = MASS
        stiffness = Fraction(0)
    distances = [half, *[2 * half] * (len(centres) - 1)]
    return {
        "stiffness": stiffness,
        "sizes": distances,
        "heights": centres,
        "weight": mass * GRAVITY,
    }


BLOCKS = {"block": 1, "stack": 2}
SCENES: dict[str, Callable[[], Scene]] = {"block": block, "stack": stack, "spheres": spheres}

_FALL = float(np.sqrt(SIDES[2] / float(GRAVITY)))
_CHAIN = float(np.sqrt(float(BALL_MASS / STIFFNESS) / ((3 + np.sqrt(5)) / 2)))
"""1/omega of the faster mode of two masses on two equal springs: omega^2 = (3 + sqrt 5)/2 k/m."""
SCALES = {
    "block": Scales(SIDES[2], _FALL, 20 * _FALL, float(MASS)),
    "stack": Scales(SIDES[2], _FALL, 20 * _FALL, float(MASS)),
    "spheres": Scales(float(RADIUS), _CHAIN, 20 * _CHAIN, float(BALL_MASS)),
}
