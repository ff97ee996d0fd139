"""Degrees of freedom of points on rods: number of coordinates minus the rank of the constraint
Jacobian (chapter 1, section 1.1).
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

RANK_TOLERANCE = 1e-9
"""Relative size of singular values that count as zero; those of independent unit rods are far
larger.
"""


def rod_jacobian(position: ArrayLike, rods: Sequence[tuple[int, int]]) -> Array:
    """Derivatives (M, N D) of the lengths of M rods with respect to the coordinates of N points in
    D dimensions.

    position (N, D) [m]. For |x_a - x_b| they are the unit vector from b to a at point a, and its
    negative at b.
    """
    points = np.asarray(position, float)
    count, dimension = points.shape
    rows = np.zeros((len(rods), count, dimension))
    for row, (a, b) in zip(rows, rods, strict=True):
        branch = points[a] - points[b]
        row[a] = branch / np.linalg.norm(branch)
        row[b] = -row[a]
    return rows.reshape(len(rods), count * dimension)


def first_order_freedom(position: ArrayLike, rods: Sequence[tuple[int, int]]) -> int:
    """Number of independent velocities that keep all rod lengths to first order: N D minus the rank
    of the Jacobian.

    In a degenerate configuration (all points in a plane, or on a line) some of them do not extend
    to finite motions.
    """
    if not len(rods):
        return int(np.asarray(position).size)
    jacobian = rod_jacobian(position, rods)
    return int(jacobian.shape[1] - rank(jacobian))


def rigid_freedom(position: ArrayLike) -> int:
    """Dimension of the rigid motions of points whose distances are all fixed: translations, and
    rotations that move some point.

    In D dimensions there are D translations and D (D - 1)/2 rotations, of which those among the I
    directions without extent, I (I - 1)/2, move no point.
    """
    points = np.asarray(position, float)
    dimension = int(points.shape[1])
    # D + D (D - 1)/2 - I (I - 1)/2.
    flat_directions = dimension - rank(points - points.mean(axis=0))
    return dimension + (dimension * (dimension - 1) - flat_directions * (flat_directions - 1)) // 2


def orthogonal_freedom(turn: Array) -> int:
    """Number of independent rates X (3, 3) of the nine entries of M = `turn` that leave M^T M
    constant: 9 minus the rank of X -> M^T X + X^T M, which is 6 for a rotation matrix.
    """
    conditions = []
    for entry in range(9):
        rate = np.zeros(9)
        rate[entry] = 1.0
        # M^T X + X^T M = 0.
        half = turn.T @ rate.reshape(3, 3)
        conditions.append((half + half.T).ravel())
    return 9 - rank(np.array(conditions))


def rank(matrix: Array) -> int:
    """The numerical rank: the number of singular values above RANK_TOLERANCE times the largest."""
    singular_values = np.linalg.svd(matrix, compute_uv=False)
    if not singular_values.size or singular_values[0] <= 0:
        return 0
    return int(np.count_nonzero(singular_values > RANK_TOLERANCE * singular_values[0]))


def complete_graph(count: int) -> list[tuple[int, int]]:
    """Every pair of `count` points."""
    return list(combinations(range(count), 2))
