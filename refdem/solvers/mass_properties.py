"""Mass properties of solids: polyhedra by signed tetrahedra, plates by signed triangles, round ones
by stretching (mechanics).
"""

from time import perf_counter
from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Request, Solid
from refdem.core.statics import (
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
        """None: every shape that a solid can have is known."""
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Mass, centre of mass and tensor of every solid."""
        problem = request.problem
        assert isinstance(problem, Solid)
        started = perf_counter()
        values = properties(problem, said)
        return Trajectory.of_values(problem.times, values), Cost(seconds=perf_counter() - started)


def said(piece: Piece) -> dict[str, float]:
    """All that is asked of one solid."""
    found = of_piece(piece)
    if piece.about is None:
        tensor = found.inertia
    else:
        tensor = found.about(piece.about)
    return body(found.mass, found.centre, tensor)


def of_piece(piece: Piece) -> mechanics.MassProperties:
    """The mass properties of one solid, hollowed and turned."""
    found = of_shape(piece.shape, piece.density)
    if piece.hollow is not None:
        found = found - of_shape(piece.hollow, piece.density)
    attitude = np.array(piece.attitude)
    return found.turned(matrix(attitude / np.linalg.norm(attitude)))


def of_shape(shape: Any, density: float) -> mechanics.MassProperties:
    """The mass properties of one shape at the origin."""
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
