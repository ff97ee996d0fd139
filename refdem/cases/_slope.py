"""The block on a slope: x runs down the slope, y is its normal, and gravity is tilted."""

import numpy as np

from refdem.core.parameters import Parameters
from refdem.scene import Body, Scene, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

SIDES = (2.0, 0.25, 2.0)
"""Of the block [m]: flat, so that it slides before it tips on any slope below 8 in 1."""


def tilt(p: Parameters) -> tuple[float, float]:
    """Sine and cosine of the slope's angle, from the parameter `angle` or from its tangent `slope`.

    With s = tan(angle): sin = s/sqrt(1 + s^2), cos = 1/sqrt(1 + s^2).
    """
    if p.angle is not None:
        return float(np.sin(p.angle)), float(np.cos(p.angle))
    hypotenuse = float(np.hypot(1, p.slope))
    return p.slope / hypotenuse, 1 / hypotenuse


def scene(p: Parameters) -> Scene:
    """The block flat on the plane y = 0."""
    sine, cosine = tilt(p)
    # J_x = m/12 (b^2 + c^2) for the sides a, b, c, and so on.
    squares = np.square(SIDES)
    x, y, z = (p.mass / 12 * (squares.sum() - squares)).tolist()
    height = SIDES[1]
    block = Body(mass=p.mass, inertia=(x, y, z), position=(0.0, height / 2, 0.0), shape=box(*SIDES))
    gravity = UniformGravity(g=(p.gravity * sine, -p.gravity * cosine, 0.0))
    contact = Contact(law="rigid", friction=p.friction)
    return Scene.of([block], [Plane(normal=(0.0, 1.0, 0.0)), gravity, contact])
