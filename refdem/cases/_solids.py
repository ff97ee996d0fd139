"""The solids of moments-of-inertia: Table 1.1, its limits, hollow ones, plates, points, and what is
not convex.
"""

from typing import Any

import numpy as np

from refdem.core.parameters import Parameters
from refdem.core.statics import Cuboid, Cylinder, Ellipsoid, Piece, Points, Polygon
from refdem.scene.shapes import Polyhedron

PRISM = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
"""Faces of a prism whose ends are 0, 1, 2, counter-clockwise from above, and 3, 4, 5 above them."""


def polyhedron(vertices: Any, faces: Any) -> Polyhedron:
    """The polyhedron with these vertices [m] and faces."""
    return Polyhedron(vertices=tuple(vertices), faces=tuple(faces))


def pyramid(a: float, b: float, c: float) -> Polyhedron:
    """Base a by b in z = 0 about the origin, apex at (0, 0, c)."""
    base = [
        (-a / 2, -b / 2, 0.0),
        (a / 2, -b / 2, 0.0),
        (a / 2, b / 2, 0.0),
        (-a / 2, b / 2, 0.0),
    ]
    faces = [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    return polyhedron([*base, (0.0, 0.0, c)], faces)


def wedge(left: float, right: float, top: float, height: float, depth: float) -> Polyhedron:
    """A prism over the triangle left .. right at z = 0 with its tip above `top`, `depth` deep along
    y.
    """
    vertices = []
    for y in (-depth / 2, depth / 2):
        vertices += [(left, y, 0.0), (right, y, 0.0), (top, y, height)]
    # The ends lie along y here, which turns the faces inside out.
    faces = [tuple(reversed(face)) for face in PRISM]
    return polyhedron(vertices, faces)


def angle_plan(a: float, b: float) -> list[tuple[float, float]]:
    """[0, a] [0, b] without the quarter x > a/2, y > b/2, counter-clockwise."""
    return [(0.0, 0.0), (a, 0.0), (a, b / 2), (a / 2, b / 2), (a / 2, b), (0.0, b)]


def angle(a: float, b: float, c: float) -> Polyhedron:
    """The prism over the plan of an angle, from z = 0 to c."""
    plan = angle_plan(a, b)
    n = 6
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    top = [(n, n + 1, n + 2, n + 3), (n, n + 3, n + 4, n + 5)]
    floor = [tuple(i - n for i in reversed(face)) for face in top]
    lower = [(x, y, 0.0) for x, y in plan]
    upper = [(x, y, c) for x, y in plan]
    return polyhedron(lower + upper, [*sides, *floor, *top])


def solids(p: Parameters) -> list[Piece]:
    """Every solid, by the names that truth has for it."""
    a = p.a
    b = p.b
    c = p.c
    hollow = p.hollow
    corner = polyhedron(
        [(0.0, 0.0, 0.0), (a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c)],
        [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)],
    )
    points = Points(
        mass=(1.0, 2.0, 3.0, 4.0), position=((0.0, 0.0, 0.0), (a, 0.0, 0.0), (a, b, 0.0), (a, b, c))
    )
    cuboid = Cuboid(sides=(a, b, c))
    cylinder = Cylinder(half_axes=(a, a), height=c)
    shapes: dict[str, Any] = {
        "cuboid": cuboid,
        "ellipsoid": Ellipsoid(half_axes=(a, b, c)),
        "elliptical-cylinder": Cylinder(half_axes=(a, b), height=c),
        "rectangular-pyramid": pyramid(a, b, c),
        "right-angle-wedge": wedge(0.0, a, 0.0, c, b),
        "isosceles-wedge": wedge(-b / 2, b / 2, 0.0, c, a),
        "tetrahedron": corner,
        "angle": angle(a, b, c),
        "triangle": Polygon(vertices=((0.0, 0.0), (b, 0.0), (a, c))),
        "angle-plate": Polygon(vertices=tuple(angle_plan(a, b))),
        "points": points,
    }
    inner: dict[str, tuple[Any, Any]] = {
        "hollow-cuboid": (cuboid, Cuboid(sides=(a * hollow, b * hollow, c * hollow))),
        "hollow-cylinder": (cylinder, Cylinder(half_axes=(a * hollow, a * hollow), height=c)),
    }
    found = [Piece(name=name, shape=shape, density=p.density) for name, shape in shapes.items()]
    found += [
        Piece(name=name, shape=whole, hollow=part, density=p.density)
        for name, (whole, part) in inner.items()
    ]
    attitude = tuple(p.attitude.tolist())
    found.append(
        Piece(name="turned-tetrahedron", shape=corner, density=p.density, attitude=attitude)
    )
    edge = (a / 2, b / 2, c / 2)
    found.append(Piece(name="cuboid-at-corner", shape=cuboid, density=p.density, about=edge))
    return found


def volume(name: str, p: Parameters) -> float:
    """About the volume [m^3] of a solid (area of a plate [m^2]), of a hollow one with its hollow:
    the scale of its mass.
    """
    areas = {
        "triangle": p.b * p.c / 2,
        "angle-plate": p.a * p.b * 3 / 4,
        "hollow-cylinder": np.pi * p.a**2 * p.c,
    }
    # Parts of the cuboid a b c.
    shares = {
        "tetrahedron": 1 / 6,
        "turned-tetrahedron": 1 / 6,
        "rectangular-pyramid": 1 / 3,
        "ellipsoid": 4 * np.pi / 3,
        "elliptical-cylinder": np.pi,
        "right-angle-wedge": 1 / 2,
        "isosceles-wedge": 1 / 2,
        "angle": 3 / 4,
    }
    share = shares.get(name, 1.0)
    return float(areas.get(name, p.a * p.b * p.c * share))
