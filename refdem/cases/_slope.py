"""A block on a plane, level or sloping: y is the normal of the plane, and gravity is tilted towards
x, or towards another direction in the plane.
"""

import numpy as np

from refdem.core.parameters import Parameters
from refdem.scene import Body, Scene, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

SIDES = (2.0, 0.25, 2.0)
"""Of the block [m]: flat, so that it slides before it tips on any slope below 8 in 1."""
PLANE = Plane(normal=(0.0, 1.0, 0.0))
"""Level in the case's axes: it is gravity that is tilted."""


def tilt(p: Parameters) -> tuple[float, float]:
    """Sine and cosine of the slope's angle, from the parameter `angle` or from its tangent `slope`.

    With s = tan(angle): sin = s/sqrt(1 + s^2), cos = 1/sqrt(1 + s^2).
    """
    if p.angle is not None:
        return float(np.sin(p.angle)), float(np.cos(p.angle))
    hypotenuse = float(np.hypot(1, p.slope))
    return p.slope / hypotenuse, 1 / hypotenuse


def downhill(p: Parameters) -> tuple[float, float]:
    """Components along x and z of the unit vector that points down the slope."""
    return float(np.cos(p.heading)), float(np.sin(p.heading))


def scene(p: Parameters) -> Scene:
    """The block flat on the plane y = 0."""
    sine, cosine = tilt(p)
    along_x, along_z = downhill(p)
    down = p.gravity * sine
    gravity = UniformGravity(g=(down * along_x, -p.gravity * cosine, down * along_z))
    return Scene.of([block(p.mass)], [PLANE, gravity, Contact(law="rigid", friction=p.friction)])


def height() -> float:
    """The height of the block's centre over the plane [m]."""
    return SIDES[1] / 2


def block(mass: float, x: float = 0.0, v: float = 0.0) -> Body:
    """A block that lies on the plane y = 0."""
    # J_x = m/12 (b^2 + c^2) for the sides a, b, c, and so on.
    squares = np.square(SIDES)
    jx, jy, jz = (mass / 12 * (squares.sum() - squares)).tolist()
    return Body(
        mass=mass,
        inertia=(jx, jy, jz),
        position=(x, height(), 0.0),
        velocity=(v, 0.0, 0.0),
        shape=box(*SIDES),
    )
