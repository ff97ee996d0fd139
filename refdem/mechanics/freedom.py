"""Degrees of freedom of points on rods: variables minus the rank of the constraint Jacobian
(chapter 1, section 1.1).
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

RANK_TOLERANCE = 1e-9
"""Singular values below this part of the largest are zero: those of unit rods that are independent
are far above.
"""


def rod_jacobian(position: ArrayLike, rods: Sequence[tuple[int, int]]) -> Array:
    """Derivative (M, N D) of every rod's length by the coordinates of points at `position` (N, D)
    [m]: unit vectors along it.
    """
    points = np.asarray(position, float)
    count, dimension = points.shape
    rows = np.zeros((len(rods), count, dimension))
    for row, (a, b) in zip(rows, rods, strict=True):
        along = points[a] - points[b]
        row[a] = along / np.linalg.norm(along)
        row[b] = -row[a]
    return rows.reshape(len(rods), count * dimension)


def first_order_freedom(position: ArrayLike, rods: Sequence[tuple[int, int]]) -> int:
    """Independent velocities that keep the rods to first order: N D minus the rank, at this
    placement of the points.

    A degenerate placement (all in a plane, all on a line) has more of them than finite motions.
    """
    if not len(rods):
        return int(np.asarray(position).size)
    jacobian = rod_jacobian(position, rods)
    return int(jacobian.shape[1] - rank(jacobian))


def rigid_freedom(position: ArrayLike) -> int:
    """Dimension of the finite motions of points whose distances are all kept: translations, and
    turns that move some point.
    """
    points = np.asarray(position, float)
    dimension = int(points.shape[1])
    # Turns of the directions in which the points have no extent move nothing:
    # D + D (D - 1)/2 - I (I - 1)/2 for I such directions.
    idle = dimension - rank(points - points.mean(axis=0))
    return dimension + (dimension * (dimension - 1) - idle * (idle - 1)) // 2


def rank(matrix: Array) -> int:
    """The numerical rank: how many singular values are above RANK_TOLERANCE times the largest."""
    sizes = np.linalg.svd(matrix, compute_uv=False)
    if not sizes.size or sizes[0] <= 0:
        return 0
    return int(np.count_nonzero(sizes > RANK_TOLERANCE * sizes[0]))


def complete_graph(count: int) -> list[tuple[int, int]]:
    """Every pair of `count` points."""
    return list(combinations(range(count), 2))
