"""The operations of the case rotations that compare the nine entries of a matrix with the four of a
quaternion: one step of R' = [omega] R and of q' = omega q/2 by Euler's method, with [omega] r =
omega x r, and the nearest rotation (chapter 1, footnote 2 of section 1.3.9).
"""

import numpy as np

from refdem.cases._algebra import Row
from refdem.core.parameters import Parameters

DECOMPOSED = 13.0
"""The magnitude that accounts for the relative error of M = U S V^T in a correct program.

LAPACK's iteration (Demmel and Kahan 1990) neglects elements smaller than u^(7/8) = 98.7 u times
their neighbours (u = 2^-53). The bound of four units in the last place, 8 u, is therefore
multiplied by 13. For 680,000 matrices with rotation vectors of length 0 to 1e5 the largest error
was 51.3 u times the condition.
"""


def rows(p: Parameters) -> list[Row]:
    """A step of the matrix and of the quaternion of the same Euler angles, the conditions that each
    violates after it, and the angle by which the nearest rotation lags behind the exact one.
    """
    turn = turned_in_a_step(p).tolist()
    # M = (1 + [v]) R with v = h omega; M^T M - 1, det M = 1 + |v|^2, and the rotation U V^T nearest
    # to M = U S V^T.
    nine: list[Row] = [
        ("nine-entries-freedom", "orthogonal-freedom", ["euler-matrix"]),
        ("nine-entries", "first-order-turn", ["euler-matrix", turn]),
        ("nine-entries-defect", "orthogonality", ["nine-entries"]),
        ("nine-entries-determinant", "determinant", ["nine-entries"]),
        ("nine-entries-back", "nearest-turn", ["nine-entries"]),
    ]
    # q + (0, v) q/2, its length sqrt(1 + |v|^2/4), and the unit quaternion along it.
    four: list[Row] = [
        ("four-entries-rate", "rate", ["euler-quaternion", turn]),
        ("four-entries", "sum", ["euler-quaternion", "four-entries-rate"]),
        ("four-entries-length", "absolute", ["four-entries"]),
        ("four-entries-back", "unit", ["four-entries"]),
        ("four-entries-matrix", "matrix-of-quaternion", ["four-entries-back"]),
    ]
    return nine + four + _lag_rows(p)


def _lag_rows(p: Parameters) -> list[Row]:
    """The exact rotation of the step, and the angles by which the two rotations lag behind it."""
    turn = turned_in_a_step(p)
    angle = float(np.linalg.norm(turn))
    axis = (turn / angle).tolist()
    # W = T R with the rotation T by |v| about v. The lag of a rotation Q is the angle of W^T Q: |v|
    # - atan |v| for nine entries, |v| - 2 atan(|v|/2) for four.
    return [
        ("whole-turn", "turn-about", [axis, [angle]]),
        ("whole-quaternion", "quaternion-about", [axis, [angle]]),
        ("whole", "matrix-product", ["whole-turn", "euler-matrix"]),
        ("whole-back", "transpose", ["whole"]),
        ("nine-entries-between", "matrix-product", ["whole-back", "nine-entries-back"]),
        ("nine-entries-lag", "turn-angle", ["nine-entries-between"]),
        ("four-entries-between", "matrix-product", ["whole-back", "four-entries-matrix"]),
        ("four-entries-lag", "turn-angle", ["four-entries-between"]),
    ]


def turned_in_a_step(p: Parameters) -> np.ndarray:
    """The rotation vector (3,) [rad] of a step: its duration times omega."""
    turn: np.ndarray = p.step * p.omega
    return turn


def sizes(p: Parameters) -> dict[str, float]:
    """The magnitudes of the results by name, for a step with a turn by any angle."""
    stretch = 1 + float(np.linalg.norm(turned_in_a_step(p)))
    angles = ("whole-turn", "whole-quaternion")
    lengths = ("nine-entries", "four-entries-rate", "four-entries", "four-entries-length")
    nearest = DECOMPOSED * condition_of_nearest_turn(p)
    # The errors of the factors of a product of rotations add up; Euler's matrix has three.
    whole = stretch + 3
    return {
        # A rounding error of the angle |v| moves everything that is rotated by it.
        **dict.fromkeys(angles, stretch),
        **dict.fromkeys(lengths, stretch),
        **dict.fromkeys(("whole", "whole-back"), whole),
        # An error of M counts twice in M^T M.
        "nine-entries-defect": 2 * stretch**2,
        "nine-entries-determinant": stretch**3,
        "nine-entries-back": nearest,
        "nine-entries-between": whole + nearest,
        "nine-entries-lag": whole + nearest,
        # An error of a unit quaternion counts twice in its matrix.
        "four-entries-matrix": 2.0,
        "four-entries-between": whole + 2,
        "four-entries-lag": whole + 2,
    }


def condition_of_nearest_turn(p: Parameters) -> float:
    """The condition of the nearest rotation Q: its error over a relative error of M = (1 + [v]) R.

    For M = Q H with H symmetric and positive, dM = dQ H + Q dH. With dQ = Q W, W antisymmetric, the
    antisymmetric part A of Q^T dM has W H + H W = 2 A, so that between the axes i and j of H

        W_ij = 2 A_ij/(s_i + s_j),   |dQ| <= 2 |dM|/(s_1 + s_2),

    with the smallest singular values s_1 and s_2. Those of 1 + [v] are 1 (along v) and twice s =
    sqrt(1 + |v|^2), so that |dQ| <= 2 s/(1 + s) |dM|/s. The condition 2 s/(1 + s) is 1 for v = 0
    and less than 2 for any v.
    """
    s = float(np.hypot(1.0, np.linalg.norm(turned_in_a_step(p))))
    return 2 * s / (1 + s)
