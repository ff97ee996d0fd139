"""Rotations of balls: quaternions (w, x, y, z) from body to space and matrices as lists of rows."""

from collections.abc import Sequence

from flint import arb

from refdem.truth.balls import UndecidedError
from refdem.truth.vectors import cross as cross

Vector = Sequence[arb]
Matrix = Sequence[Sequence[arb]]


def dot(a: Vector, b: Vector) -> arb:
    """The dot product a . b of two vectors."""
    return sum((x * y for x, y in zip(a, b, strict=True)), arb(0))


def times(p: Vector, q: Vector) -> list[arb]:
    """The quaternion product p q: (a, u) (b, v) = (a b - u.v, a v + b u + u x v)."""
    a, *u = p
    b, *v = q
    w = cross(u, v)
    vector = [a * v[i] + b * u[i] + w[i] for i in range(3)]
    return [a * b - dot(u, v), *vector]


def conjugate(q: Vector) -> list[arb]:
    """The conjugate of a quaternion: the reverse rotation."""
    return [q[0], -q[1], -q[2], -q[3]]


def turn(axis: Vector, angle: arb) -> list[arb]:
    """The quaternion of a turn by `angle` [rad] about a unit axis."""
    sine, cosine = (angle / 2).sin_cos()
    return [cosine, *(sine * x for x in axis)]


def matrix(q: Vector) -> list[list[arb]]:
    """The matrix of a unit quaternion, body to space."""
    w, x, y, z = q
    # R = 1 + 2 w [u]x + 2 [u]x^2 with u = (x, y, z), [u]x a = u x a, and w^2 + u^2 = 1.
    first = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
    second = [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
    third = [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    return [first, second, third]


def quaternion(r: Matrix) -> list[arb]:
    """A unit quaternion (w, x, y, z) of a rotation matrix R (either sign), from its largest
    component (Shepperd 1978).

    4 w^2 = 1 + tr R, 4 q_i^2 = 1 + 2 R_ii - tr R; 4 w q_i is the i-th component of the
    antisymmetric part, 4 q_i q_j = R_ij + R_ji. Division by the largest loses no digits.
    """
    trace = r[0][0] + r[1][1] + r[2][2]
    squares = [(1 + trace) / 4, *((1 + 2 * r[i][i] - trace) / 4 for i in range(3))]
    number = max(range(4), key=lambda i: float(squares[i].mid()))
    # The vector of R - R^T, which is 4 w (x, y, z).
    antisymmetric = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    largest = squares[number].sqrt()
    # w is the largest component: w^2 = (1 + tr R)/4, q_i = (R - R^T)_i/(4 w).
    if number == 0:
        return [largest, *(s / (4 * largest) for s in antisymmetric)]
    i = number - 1
    # q_i is the largest component: q_j = (R_ij + R_ji)/(4 q_i) for j != i, and
    # w = (R - R^T)_i/(4 q_i).
    vector = [(r[i][j] + r[j][i]) / (4 * largest) for j in range(3)]
    vector[i] = largest
    return [antisymmetric[i] / (4 * largest), *vector]


def product(a: Matrix, b: Matrix) -> list[list[arb]]:
    """The product a b of two matrices, as rows."""
    return [[dot(row, column) for column in zip(*b, strict=True)] for row in a]


def transposed(a: Matrix) -> list[list[arb]]:
    """The transpose of a matrix, as rows."""
    return [list(column) for column in zip(*a, strict=True)]


def applied(a: Matrix, v: Vector) -> list[arb]:
    """The product a v of a matrix and a vector."""
    return [dot(row, v) for row in a]


def rotated(q: Vector, v: Vector) -> list[arb]:
    """The vector v of the body in space, q v q*."""
    return times(times(q, [arb(0), *v]), conjugate(q))[1:]


def upright(q: Vector) -> list[arb]:
    """The one of q and -q whose first component that is not exactly 0 is positive.

    UndecidedError if balls do not decide which one it is.
    """
    for x in q:
        if x > 0:
            return list(q)
        if x < 0:
            return [-y for y in q]
        if not x.is_zero():
            raise UndecidedError(f"the sign of the attitude: a component is {x}")
    raise UndecidedError("the zero quaternion has no sign")
