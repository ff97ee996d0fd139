"""Quaternions as complex 2 x 2 matrices, in ball arithmetic.

The quaternion q = (w, x, y, z) stands for the matrix

    M(q) = w 1 - i (x s1 + y s2 + z s3) = [[w - i z, -y - i x], [y - i x, w + i z]]

with Pauli's matrices s1, s2, s3.
"""

from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.complex_balls import Complex, ComplexMatrix


def matrix_of(w: arb, x: arb, y: arb, z: arb) -> ComplexMatrix:
    """The complex 2 x 2 matrix of the quaternion (w, x, y, z)."""
    # Complex(real part, imaginary part): [[w - i z, -y - i x], [y - i x, w + i z]].
    return ComplexMatrix.of([[Complex(w, -z), Complex(-y, -x)], [Complex(y, -x), Complex(w, z)]])


def of_numbers(numbers: Sequence[Fraction]) -> ComplexMatrix:
    """The matrix of four exact numbers (w, x, y, z), or of three, (x, y, z), with w = 0."""
    if len(numbers) == 3:
        numbers = (Fraction(0), *numbers)
    w, x, y, z = (arb_of(number) for number in numbers)
    return matrix_of(w, x, y, z)


def of_balls(v: Sequence[arb]) -> ComplexMatrix:
    """The matrix of the vector (x, y, z) of balls, as a quaternion with w = 0."""
    x, y, z = v
    return matrix_of(arb(0), x, y, z)


def numbers_of(m: ComplexMatrix) -> list[arb]:
    """The quaternion (w, x, y, z) of a matrix, from its first column (w - i z, y - i x)."""
    return [m[0, 0].real, -m[1, 0].imag, m[1, 0].real, -m[0, 0].imag]


def conjugated(m: ComplexMatrix) -> ComplexMatrix:
    """The matrix of the conjugate quaternion: the conjugate transpose."""
    # With q* = (w, -x, -y, -z): M(q*) = M(q)^H.
    return m.adjoint()


def absolute(m: ComplexMatrix) -> arb:
    """|q|: the square root of the determinant."""
    # det M(q) = (w - i z)(w + i z) + (y + i x)(y - i x) = w^2 + x^2 + y^2 + z^2.
    return m.determinant().real.sqrt()
