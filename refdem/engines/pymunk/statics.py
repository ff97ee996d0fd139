"""Mass properties of plates and rotation of plane vectors, both by pymunk."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
import pymunk

from refdem.core.problem import Identity, Request, Solid
from refdem.core.static_problems import Piece, Polygon, properties, results
from refdem.core.trajectory import Cost, Trajectory


def run(request: Request) -> tuple[Trajectory, Cost]:
    """Mass, centre and polar moment of plates, or the results of operations."""
    problem = request.problem
    started = perf_counter()
    if isinstance(problem, Solid):
        values = properties(problem, of_plate)
    else:
        assert isinstance(problem, Identity)
        values = results(problem, ANSWERS)
    return Trajectory.of_values(problem.times, values), Cost(seconds=perf_counter() - started)


def of_plate(piece: Piece) -> dict[str, float] | None:
    """Mass properties of a convex polygon; None for others, of which pymunk takes the hull."""
    if not isinstance(piece.shape, Polygon) or not _is_convex(piece.shape):
        return None
    vertices = list(piece.shape.vertices)
    shape = pymunk.Poly(None, vertices)
    mass = piece.density * pymunk.area_for_poly(vertices)
    centre = shape.center_of_gravity
    moment = pymunk.moment_for_poly(mass, vertices, (-centre.x, -centre.y))
    return {"mass": mass, "centre.x": centre.x, "centre.y": centre.y, "inertia.zz": moment}


def _is_convex(polygon: Polygon) -> bool:
    """True if the polygon turns left at every corner."""
    corners = np.array(polygon.vertices)
    sides = np.roll(corners, -1, axis=0) - corners
    next_sides = np.roll(sides, -1, axis=0)
    x, y = sides.T
    next_x, next_y = next_sides.T
    # The cross product of a side and the next one is positive in a turn to the left.
    return bool(np.all(x * next_y > y * next_x))


ANSWERS: dict[str, Callable[..., Any]] = {
    "plane-turn": lambda angle, v: pymunk.Vec2d(*v).rotated(angle[0]),
    "complex-turn": (
        lambda angle, v: pymunk.Vec2d(*v).cpvrotate(
            pymunk.Vec2d(np.cos(angle[0]), np.sin(angle[0]))
        )
    ),
}
"""pymunk's own function for each operation that it has."""
