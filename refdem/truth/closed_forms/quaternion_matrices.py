"""Quaternions as complex 2 x 2 matrices, in ball arithmetic.

The quaternion q = (w, x, y, z) stands for the matrix

    M(q) = w 1 - i (x s1 + y s2 + z s3) = [[w - i z, -y - i x], [y - i x, w + i z]]

with Pauli's matrices s1, s2, s3.
"""

from collections.abc import Sequence
from fractions import Fraction

from flint import acb, acb_mat, arb

from refdem.truth.balls import arb_of


def matrix_of(w: arb, x: arb, y: arb, z: arb) -> acb_mat:
    """The complex 2 x 2 matrix of the quaternion (w, x, y, z)."""
    return acb_mat([[acb(w, -z), acb(-y, -x)], [acb(y, -x), acb(w, z)]])


def of_numbers(numbers: Sequence[Fraction]) -> acb_mat:
    """The matrix of four exact numbers (w, x, y, z), or of three, (x, y, z), with w = 0."""
    if len(numbers) == 3:
        numbers = (Fraction(0), *numbers)
    w, x, y, z = (arb_of(number) for number in numbers)
    return matrix_of(w, x, y, z)


def of_balls(v: Sequence[arb]) -> acb_mat:
    """The matrix of the vector (x, y, z) of balls, as a quaternion with w = 0."""
    x, y, z = v
    return matrix_of(arb(0), x, y, z)


def numbers_of(m: acb_mat) -> list[arb]:
    """The quaternion (w, x, y, z) of a matrix, from its first column (w - i z, y - i x)."""
    return [m[0, 0].real, -m[1, 0].imag, m[1, 0].real, -m[0, 0].imag]


def conjugated(m: acb_mat) -> acb_mat:
    """The matrix of the conjugate quaternion: the conjugate transpose."""
    return acb_mat([[m[j, i].conjugate() for j in range(2)] for i in range(2)])


def absolute(m: acb_mat) -> arb:
    """|q|: the square root of the determinant."""
    return (m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]).real.sqrt()
