"""Shapes and planes of a scene as shapes of Chipmunk, with friction and elasticity of each."""

from math import sqrt

import numpy as np
import pymunk

from refdem.engines.pymunk.unsupported import outline
from refdem.scene import Polyhedron, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.shapes import extent

WALL = 1e3
"""Half the length and the depth of a wall, in units of the scene's size, so that no body can pass
around it.
"""


def add_shapes(space: pymunk.Space, scene: Scene, bodies: list[pymunk.Body]) -> bool:
    """Adds shapes and walls to the space if the scene has a rigid contact law; True if it has."""
    law = next(iter(scene.all(Contact)), None)
    if law is None or law.law != "rigid" or not scene.has_shapes():
        return False
    shapes: list[pymunk.Shape] = []
    for body, shape in zip(bodies, scene.bodies.shape, strict=True):
        if isinstance(shape, Sphere):
            shapes.append(pymunk.Circle(body, shape.radius))
        elif isinstance(shape, Polyhedron):
            shapes.append(pymunk.Poly(body, outline(shape) or []))
    farthest = float(np.abs(scene.bodies.position).max())
    largest = max(extent(shape) for shape in scene.bodies.shape)
    half_length = WALL * max(farthest, largest)
    walls = [_wall(space, plane, half_length) for plane in scene.all(Plane)]
    for name, value in (("friction", law.friction), ("elasticity", law.restitution)):
        of_shapes, of_walls = factors(value, is_alone=len(shapes) == 1)
        for solid in shapes:
            setattr(solid, name, of_shapes)
        for wall in walls:
            setattr(wall, name, of_walls)
    space.add(*shapes, *walls)
    return True


def factors(value: float, *, is_alone: bool) -> tuple[float, float]:
    """The coefficients of shapes and of walls. Chipmunk multiplies those of a pair, and the product
    is `value`.

    For a shape that is alone the product is exact. The square of a rounded root may be smaller:
    with sqrt(3/4)^2 = 3/4 (1 - 1.5e-16) a block would slide down the slope 3/4.
    """
    of_shapes = value
    if not is_alone:
        # The product for two shapes is sqrt(value)^2.
        of_shapes = sqrt(value)
    if not of_shapes:
        return of_shapes, 0.0
    return of_shapes, value / of_shapes


def _wall(space: pymunk.Space, plane: Plane, half_length: float) -> pymunk.Shape:
    """A rectangle behind the plane, `half_length` [m] deep and twice as long."""
    point = np.array(plane.point[:2])
    normal = np.array(plane.normal[:2])
    tangent = np.array([-normal[1], normal[0]]) * half_length
    depth = half_length * normal
    corners = [point + tangent, point - tangent, point - tangent - depth, point + tangent - depth]
    return pymunk.Poly(space.static_body, [tuple(corner.tolist()) for corner in corners])
