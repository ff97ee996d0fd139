"""Rotation algebra by REBOUND's unit quaternions, `rebound.Rotation`."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
import rebound
from numpy.typing import NDArray

from refdem.core.problem import Identity, Request
from refdem.core.static_problems import results
from refdem.core.trajectory import Cost, Trajectory

Array = NDArray[np.float64]


def run(request: Request) -> tuple[Trajectory, Cost]:
    """The results of the operations, and the time they took."""
    problem = request.problem
    started = perf_counter()
    assert isinstance(problem, Identity)
    trajectory = Trajectory.of_values(problem.times, results(problem, ANSWERS))
    return trajectory, Cost(seconds=perf_counter() - started)


def rotation(q: Array) -> Any:
    """REBOUND's quaternion, whose scalar part is `r` and comes last."""
    w, x, y, z = q
    return rebound.Rotation(ix=x, iy=y, iz=z, r=w)


def numbers(rotation: Any) -> list[float]:
    """A rotation of REBOUND as the quaternion (w, x, y, z)."""
    return [rotation.r, rotation.ix, rotation.iy, rotation.iz]


ANSWERS: dict[str, Callable[..., Any]] = {
    "quaternion-about": lambda axis, angle: numbers(
        rebound.Rotation(angle=angle[0], axis=axis.tolist())
    ),
    "product": lambda p, q: numbers(rotation(p) * rotation(q)),
    "inverse": lambda q: numbers(rotation(q).inverse()),
    "unit": lambda q: numbers(rotation(q).normalize()),
    "rotated": lambda q, v: list(rotation(q) * v.tolist()),
}
"""REBOUND's own function for each operation that it has."""
