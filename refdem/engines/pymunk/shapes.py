"""A scene's shapes and planes in Chipmunk's words, and what each brings to a contact."""

from math import sqrt

import numpy as np
import pymunk

from refdem.engines.pymunk.unsupported import outline
from refdem.scene import Polyhedron, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.shapes import extent

WALL = 1e3
"""Half the length and the depth of a wall, in units of the scene's size: nothing gets around it."""


def add_shapes(space: pymunk.Space, scene: Scene, bodies: list[pymunk.Body]) -> bool:
    """Shapes and walls, where there is a rigid contact law; whether there are any."""
    law = next(iter(scene.all(Contact)), None)
    if law is None or law.law != "rigid" or not scene.has_shapes():
        return False
    shapes: list[pymunk.Shape] = []
    for body, shape in zip(bodies, scene.bodies.shape, strict=True):
        if isinstance(shape, Sphere):
            shapes.append(pymunk.Circle(body, shape.radius))
        elif isinstance(shape, Polyhedron):
            shapes.append(pymunk.Poly(body, outline(shape) or []))
    size = WALL * max(
        float(np.abs(scene.bodies.position).max()),
        *(extent(shape) for shape in scene.bodies.shape),
    )
    walls = [_wall(space, plane, size) for plane in scene.all(Plane)]
    for name, value in (("friction", law.friction), ("elasticity", law.restitution)):
        own, of_walls = shares(value, alone=len(shapes) == 1)
        for solid in shapes:
            setattr(solid, name, own)
        for wall in walls:
            setattr(wall, name, of_walls)
    space.add(*shapes, *walls)
    return True


def shares(value: float, *, alone: bool) -> tuple[float, float]:
    """What a shape and what a wall brings to a pair, of which Chipmunk takes the product: `value`,
    exactly for a shape that is alone.

    The square of a rounded root may be less: sqrt(3/4)^2 = 3/4 (1 - 1.5e-16) does not hold a block
    on the slope 3/4.
    """
    if alone:
        own = value
    else:
        own = sqrt(value)
    if not own:
        return own, 0.0
    return own, value / own


def _wall(space: pymunk.Space, plane: Plane, size: float) -> pymunk.Shape:
    """A wide and deep block behind the plane."""
    point = np.array(plane.point[:2])
    normal = np.array(plane.normal[:2])
    along = np.array([-normal[1], normal[0]]) * size
    corners = [
        point + along,
        point - along,
        point - along - size * normal,
        point + along - size * normal,
    ]
    return pymunk.Poly(space.static_body, [tuple(c.tolist()) for c in corners])
