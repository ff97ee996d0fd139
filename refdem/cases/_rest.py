"""The scenes of Newton's first law. All numbers are dyadic, so that every balance of forces is exact in binary64."""

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
GRAVITY = 9.8125
"""157/16 m/s^2: near the Earth's, and dyadic."""
MASS = 3.0
SIDES = (1.0, 1.0, 0.5)
BLOCK_INERTIA = (MASS / 12 * 1.25, MASS / 12 * 1.25, MASS / 12 * 2.0)
BALL_MASS, RADIUS, STIFFNESS = 5.0, 0.5, 8192.0


def free(velocity: Array, spin: float) -> Scene:
    """A body with three different moments that flies with `velocity` (3,) [m/s] and spins about its third axis [rad/s]."""
    return Scene.of([Body(mass=1.0, inertia=(0.5, 0.75, 1.0), velocity=tuple(velocity), omega=(0.0, 0.0, spin))])


def _ground(contact: Contact) -> tuple[Element, ...]:
    return Plane(), UniformGravity(g=(0.0, 0.0, -GRAVITY)), contact


def _blocks(count: int) -> Scene:
    """Boxes exactly on top of each other, the lowest on the ground."""
    heights = [(i + 0.5) * SIDES[2] for i in range(count)]
    bodies = [Body(mass=MASS, inertia=BLOCK_INERTIA, position=(0.0, 0.0, z), shape=box(*SIDES)) for z in heights]
    return Scene.of(bodies, _ground(Contact(law="rigid", friction=0.5)))


def block() -> Scene:
    """One block on the ground."""
    return _blocks(1)


def stack() -> Scene:
    """Two blocks."""
    return _blocks(2)


def spheres() -> Scene:
    """Two spheres, one on the other, each contact compressed by the weight above it over the stiffness."""
    compression = BALL_MASS * GRAVITY / STIFFNESS
    low = RADIUS - 2 * compression
    high = low + 2 * RADIUS - compression
    inertia = 0.4 * BALL_MASS * RADIUS**2
    bodies = [Body(mass=BALL_MASS, inertia=(inertia,) * 3, position=(0.0, 0.0, z), shape=Sphere(radius=RADIUS)) for z in (low, high)]
    return Scene.of(bodies, _ground(Contact(law="linear", stiffness=STIFFNESS)))


def balance(scene: Scene) -> dict[str, Any]:
    """Exact numbers of bodies on each other: weight of each, stiffness (0: rigid), heights of their centres, and how far these may come."""
    bodies, contact = scene.bodies, scene.all(Contact)[0]
    half = Fraction(RADIUS if contact.law == "linear" else SIDES[2] / 2)
    heights = [Fraction(float(z)) for z in bodies.position[:, 2]]
    found = {"stiffness": Fraction(contact.stiffness), "sizes": [half, *[2 * half] * (len(bodies) - 1)]}
    return {**found, "heights": heights, "weight": Fraction(float(bodies.mass[0])) * Fraction(GRAVITY)}


SCENES: dict[str, Callable[[], Scene]] = {"block": block, "stack": stack, "spheres": spheres}

_FALL = float(np.sqrt(SIDES[2] / GRAVITY))
_CHAIN = float(np.sqrt(BALL_MASS / STIFFNESS / ((3 + np.sqrt(5)) / 2)))
"""1/omega of the faster mode of two masses on two equal springs: omega^2 = (3 + sqrt 5)/2 k/m."""
SCALES = {
    "block": Scales(SIDES[2], _FALL, 20 * _FALL, MASS),
    "stack": Scales(SIDES[2], _FALL, 20 * _FALL, MASS),
    "spheres": Scales(RADIUS, _CHAIN, 20 * _CHAIN, BALL_MASS),
}
