"""The operations of the case rotations that show what nine entries of a matrix cost beside the four
of a quaternion: one step of R' = [omega] R and of q' = omega q/2 by Euler's method, and back to a
rotation (chapter 1, footnote 2 of section 1.3.9).
"""

import numpy as np

from refdem.cases._algebra import Row
from refdem.core.parameters import Parameters


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
    angles = (
        "whole-turn",
        "whole-quaternion",
        "whole",
        "whole-back",
        "nine-entries-between",
        "nine-entries-lag",
        "four-entries-between",
        "four-entries-lag",
    )
    lengths = ("nine-entries", "four-entries-rate", "four-entries", "four-entries-length")
    return {
        # An error of the angle by its last digit is in all that is turned by it.
        **dict.fromkeys(angles, stretch),
        **dict.fromkeys(lengths, stretch),
        "nine-entries-defect": stretch**2,
        "nine-entries-determinant": stretch**3,
    }
