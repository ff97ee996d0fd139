"""The operations of the case rotations that show what nine entries of a matrix cost beside the four
of a quaternion: one step of R' = [omega] R and of q' = omega q/2 by Euler's method, and back to a
rotation (chapter 1, footnote 2 of section 1.3.9).
"""

import numpy as np

from refdem.cases._algebra import Row
from refdem.core.parameters import Parameters

DECOMPOSED = 13.0
"""The magnitude that stands for the relative error of M = U S V^T by a right program.

LAPACK's iteration (Demmel and Kahan 1990) neglects what is below 98.7 u = u^(7/8) of its neighbours
(u = 2^-53), by its own choice; a bound of four units in the last place, 8 u, has to hold 13 times.
Of 680,000 matrices with turns from 0 to 1e5 none is off by more than 51.3 u times the condition.
"""


def rows(p: Parameters) -> list[Row]:
    """A step of the matrix and of the quaternion of the same Euler angles, what each loses, and how
    far each lags behind the turn once it is a rotation again.
    """
    turn = turned_in_a_step(p).tolist()
    nine: list[Row] = [
        ("nine-entries-freedom", "orthogonal-freedom", ["euler-matrix"]),
        ("nine-entries", "first-order-turn", ["euler-matrix", turn]),
        ("nine-entries-defect", "orthogonality", ["nine-entries"]),
        ("nine-entries-determinant", "determinant", ["nine-entries"]),
        ("nine-entries-back", "nearest-turn", ["nine-entries"]),
    ]
    four: list[Row] = [
        ("four-entries-rate", "rate", ["euler-quaternion", turn]),
        ("four-entries", "sum", ["euler-quaternion", "four-entries-rate"]),
        ("four-entries-length", "absolute", ["four-entries"]),
        ("four-entries-back", "unit", ["four-entries"]),
        ("four-entries-matrix", "matrix-of-quaternion", ["four-entries-back"]),
    ]
    return nine + four + _lag_rows(p)


def _lag_rows(p: Parameters) -> list[Row]:
    """The whole turn of the step, and the angles by which the two rotations lag behind it."""
    turn = turned_in_a_step(p)
    angle = float(np.linalg.norm(turn))
    axis = (turn / angle).tolist()
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
    # Of a product of rotations the errors of the factors add up; Euler's matrix has three.
    whole = stretch + 3
    return {
        # An error of the angle by its last digit is in all that is turned by it.
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
    """How many times a relative error of M = (1 + [v]) R counts in the nearest rotation Q.

    For M = Q H with H symmetric and positive, dM = dQ H + Q dH. With dQ = Q W, W antisymmetric, the
    antisymmetric part A of Q^T dM has W H + H W = 2 A, so that between the axes i and j of H

        W_ij = 2 A_ij/(s_i + s_j),   |dQ| <= 2 |dM|/(s_1 + s_2),

    s_1 and s_2 the smallest singular values. Those of 1 + [v] are 1 (along v) and twice s = sqrt(1
    + |v|^2): a relative error |dM|/s counts 2 s/(1 + s) times, 1 for no turn and less than 2 for
    any: the operation is as good for large turns as for small ones.
    """
    s = float(np.hypot(1.0, np.linalg.norm(turned_in_a_step(p))))
    return 2 * s / (1 + s)
