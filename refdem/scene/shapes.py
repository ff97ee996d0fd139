"""Shapes that bodies can have; a point cannot touch anything."""

from itertools import product

import msgspec
import numpy as np

from refdem.scene.dimension import Length, Position


class Point(msgspec.Struct, frozen=True, tag="point", tag_field="kind", forbid_unknown_fields=True):
    """A point: it has no extent and can touch nothing."""


class Sphere(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="sphere",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """A ball of `radius` [m] about the body's centre."""

    radius: Length


class Polyhedron(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="polyhedron",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """A convex body: vertices [m] in body axes; faces as lists of vertex numbers, counter-clockwise
    from outside.
    """

    vertices: tuple[Position, ...]
    faces: tuple[tuple[int, ...], ...]


Shape = Point | Sphere | Polyhedron


def extent(shape: Shape) -> float:
    """The largest distance [m] of a shape from its body's centre; 0 of a point."""
    if isinstance(shape, Polyhedron):
        return float(np.linalg.norm(shape.vertices, axis=1).max())
    if isinstance(shape, Sphere):
        return shape.radius
    return 0.0


def box(x: float, y: float, z: float) -> Polyhedron:
    """A box with full side lengths x, y, z [m] about its centre."""
    # Vertex 4 i + 2 j + k has the signs (-1)^(i+1), (-1)^(j+1), (-1)^(k+1) of x, y, z.
    signs = product((-1, 1), repeat=3)
    vertices = tuple((sx * x / 2, sy * y / 2, sz * z / 2) for sx, sy, sz in signs)
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return Polyhedron(vertices=vertices, faces=faces)
