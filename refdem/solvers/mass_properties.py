"""Mass properties of solids by the functions of `mechanics.mass_properties`: signed tetrahedra,
signed triangles, closed forms.
"""

from time import perf_counter
from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Request, Solid
from refdem.core.static_problems import (
    Cuboid,
    Cylinder,
    Ellipsoid,
    Piece,
    Points,
    Polygon,
    body,
    properties,
)
from refdem.core.trajectory import Cost, Trajectory
from refdem.mechanics import mass_properties as mechanics
from refdem.mechanics.quaternion import matrix
from refdem.scene.shapes import Sphere, box
from refdem.solvers.solver import Solver


class MassProperties(Solver):
    """Every shape that a solid can have."""

    claims = Method(
        name="mass-properties",
        summary="signed tetrahedra and triangles, exact up to rounding",
        control="exact",
        cost_rank=0,
    )
    answers = Solid

    def unsupported(self, problem: Solid) -> str | None:
        """None: every shape is supported."""
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Mass, centre of mass and inertia tensor of every solid."""
        problem = request.problem
        assert isinstance(problem, Solid)
        started = perf_counter()
        values = properties(problem, answer_of)
        return Trajectory.of_values(problem.times, values), Cost(seconds=perf_counter() - started)


def answer_of(piece: Piece) -> dict[str, float]:
    """Mass, centre and inertia tensor of one solid by name; the tensor is about the requested point
    or else the centre of mass.
    """
    solid = of_piece(piece)
    if piece.about is None:
        tensor = solid.inertia
    else:
        tensor = solid.about(piece.about)
    return body(solid.mass, solid.centre, tensor)


def of_piece(piece: Piece) -> mechanics.MassProperties:
    """Mass properties of one solid, less its hollow, after its rotation."""
    solid = of_shape(piece.shape, piece.density)
    if piece.hollow is not None:
        solid = solid - of_shape(piece.hollow, piece.density)
    attitude = np.array(piece.attitude)
    return solid.turned(matrix(attitude / np.linalg.norm(attitude)))


def of_shape(shape: Any, density: float) -> mechanics.MassProperties:
    """Mass properties of one shape at the origin with a density [kg/m^3] (polygons: [kg/m^2])."""
    match shape:
        case Points():
            return mechanics.of_points(shape.mass, shape.position)
        case Polygon():
            return mechanics.of_polygon(shape.vertices, density)
        case Ellipsoid():
            return mechanics.of_ellipsoid(shape.half_axes, density)
        case Sphere():
            return mechanics.of_ellipsoid((shape.radius,) * 3, density)
        case Cylinder():
            return mechanics.of_cylinder(shape.half_axes, shape.height, density)
        case Cuboid():
            shape = box(*shape.sides)
    return mechanics.of_polyhedron(shape.vertices, shape.faces, density)


METHOD = MassProperties()
