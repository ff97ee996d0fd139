"""The solids of moments-of-inertia: Table 1.1, its limits, hollow solids, plates, points, and an
angle, which is not convex.

A polyhedron is given by its vertices [m] and its faces, tuples of vertex numbers that are
counter-clockwise as seen from outside.
"""

from typing import Any

import numpy as np

from refdem.core.parameters import Parameters
from refdem.core.static_problems import Cuboid, Cylinder, Ellipsoid, Piece, Points, Polygon
from refdem.scene.shapes import Polyhedron

PRISM = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
"""Faces of a triangular prism. Its lower end has the vertices 0, 1, 2, counter-clockwise as seen
from above, and 3, 4, 5 are above them.
"""


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


def wedge(x_left: float, x_right: float, x_tip: float, height: float, depth: float) -> Polyhedron:
    """A triangular prism along y, from -depth/2 to depth/2.

    Its end has the base x_left .. x_right at z = 0 and the tip (x_tip, height) in x and z.
    """
    vertices = []
    for y in (-depth / 2, depth / 2):
        vertices += [(x_left, y, 0.0), (x_right, y, 0.0), (x_tip, y, height)]
    # Left, right, tip are clockwise as seen from +y, so that PRISM's faces would be inside out.
    faces = [tuple(reversed(face)) for face in PRISM]
    return polyhedron(vertices, faces)


def angle_plan(a: float, b: float) -> list[tuple[float, float]]:
    """Corners, counter-clockwise, of an L in the x-y plane.

    It is the rectangle [0, a] x [0, b] without its quarter x > a/2, y > b/2.
    """
    return [(0.0, 0.0), (a, 0.0), (a, b / 2), (a / 2, b / 2), (a / 2, b), (0.0, b)]


def angle(a: float, b: float, c: float) -> Polyhedron:
    """The prism over an L (`angle_plan`), from z = 0 to c."""
    plan = angle_plan(a, b)
    n = len(plan)
    # Vertex i of the plan is vertex i below and vertex n + i above.
    lower = [(x, y, 0.0) for x, y in plan]
    upper = [(x, y, c) for x, y in plan]
    # Side i stands on the edge from corner i to the next one.
    sides = []
    for i in range(n):
        following = (i + 1) % n
        sides.append((i, following, n + following, n + i))
    # The L is cut into two quadrilaterals along the line from corner 0 to corner 3, its inner one.
    quadrilaterals = [(0, 1, 2, 3), (0, 3, 4, 5)]
    top = [tuple(n + i for i in face) for face in quadrilaterals]
    floor = [tuple(reversed(face)) for face in quadrilaterals]
    return polyhedron(lower + upper, [*sides, *floor, *top])


def solids(p: Parameters) -> list[Piece]:
    """Every solid of the case, under the name that truth has for it."""
    a = p.a
    b = p.b
    c = p.c
    hollow = p.hollow
    # The inner radius of a hoop: a wall as thin as the stick.
    inside = a * (1 - p.thin)
    tetrahedron = polyhedron(
        [(0.0, 0.0, 0.0), (a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c)],
        [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)],
    )
    places = ((0.0, 0.0, 0.0), (a, 0.0, 0.0), (a, b, 0.0), (a, b, c))
    points = Points(mass=(1.0, 2.0, 3.0, 4.0), position=places)
    cuboid = Cuboid(sides=(a, b, c))
    cylinder = Cylinder(half_axes=(a, a), height=c)
    sphere = Ellipsoid(half_axes=(a, a, a))
    stick = Cylinder(half_axes=(p.thin * c, p.thin * c), height=c)
    shapes: dict[str, Any] = {
        "cuboid": cuboid,
        "ellipsoid": Ellipsoid(half_axes=(a, b, c)),
        "elliptical-cylinder": Cylinder(half_axes=(a, b), height=c),
        "rectangular-pyramid": pyramid(a, b, c),
        "right-angle-wedge": wedge(0.0, a, 0.0, c, b),
        "isosceles-wedge": wedge(-b / 2, b / 2, 0.0, c, a),
        "tetrahedron": tetrahedron,
        "angle": angle(a, b, c),
        "triangle": Polygon(vertices=((0.0, 0.0), (b, 0.0), (a, c))),
        "angle-plate": Polygon(vertices=tuple(angle_plan(a, b))),
        "points": points,
        "sphere": sphere,
        "stick": stick,
    }
    # Name: (the outer shape, the shape that is cut out of it).
    hollow_shapes: dict[str, tuple[Any, Any]] = {
        "hollow-cuboid": (cuboid, Cuboid(sides=(a * hollow, b * hollow, c * hollow))),
        "hollow-cylinder": (cylinder, Cylinder(half_axes=(a * hollow, a * hollow), height=c)),
        "hollow-sphere": (sphere, Ellipsoid(half_axes=(a * hollow, a * hollow, a * hollow))),
        "hoop": (cylinder, Cylinder(half_axes=(inside, inside), height=c)),
    }
    pieces = [Piece(name=name, shape=shape, density=p.density) for name, shape in shapes.items()]
    for name, (outer, inner) in hollow_shapes.items():
        pieces.append(Piece(name=name, shape=outer, hollow=inner, density=p.density))
    attitude = tuple(p.attitude.tolist())
    pieces.append(
        Piece(name="turned-tetrahedron", shape=tetrahedron, density=p.density, attitude=attitude)
    )
    corner = (a / 2, b / 2, c / 2)
    pieces.append(Piece(name="cuboid-at-corner", shape=cuboid, density=p.density, about=corner))
    end = (0.0, 0.0, c / 2)
    pieces.append(Piece(name="stick-at-end", shape=stick, density=p.density, about=end))
    return pieces


def volume(name: str, p: Parameters) -> float:
    """The volume [m^3] of a solid (area [m^2] of a plate) to within a small factor: the scale of
    its mass. A hollow solid counts with its hollow.
    """
    of_cylinder = np.pi * p.a**2 * p.c
    of_sphere = 4 * np.pi / 3 * p.a**3
    of_stick = np.pi * p.thin**2 * p.c**3
    volumes = {
        "triangle": p.b * p.c / 2,
        "angle-plate": p.a * p.b * 3 / 4,
        "hollow-cylinder": of_cylinder,
        "hoop": of_cylinder,
        "sphere": of_sphere,
        "hollow-sphere": of_sphere,
        "stick": of_stick,
        "stick-at-end": of_stick,
    }
    # The volumes of the others in units of a b c.
    fractions = {
        "tetrahedron": 1 / 6,
        "turned-tetrahedron": 1 / 6,
        "rectangular-pyramid": 1 / 3,
        "ellipsoid": 4 * np.pi / 3,
        "elliptical-cylinder": np.pi,
        "right-angle-wedge": 1 / 2,
        "isosceles-wedge": 1 / 2,
        "angle": 3 / 4,
    }
    fraction = fractions.get(name, 1.0)
    return float(volumes.get(name, p.a * p.b * p.c * fraction))


def spread(name: str, p: Parameters) -> float:
    """How much larger than its volume the terms of a sum over sides or faces may be: a solid that
    does not lie along the axes counts with its surroundings.

    Each term is rounded. Those of the triangle, whose tip is at x = a, are as large as max(a, b) c;
    where the corners of a tetrahedron are turned, as large as the cube of its longest side.
    """
    longest = max(p.a, p.b, p.c)
    spreads = {
        "triangle": max(p.a, p.b) / p.b,
        "turned-tetrahedron": longest**3 / (p.a * p.b * p.c),
    }
    return float(spreads.get(name, 1.0))
