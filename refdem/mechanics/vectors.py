"""Vectors as tuples of three numbers and quaternions (w, x, y, z) as tuples of four, of whatever
precision the numbers have.
"""

from math import cos, hypot, sin, sqrt
from typing import Any

Number = Any
"""A float, or a NumPy scalar of single precision."""
Vector = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]
ZERO: Vector = (0.0, 0.0, 0.0)


def plus(a: Vector, b: Vector) -> Vector:
    """The sum a + b of two vectors (3)."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def minus(a: Vector, b: Vector) -> Vector:
    """The difference a - b of two vectors (3)."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def times(factor: Number, a: Vector) -> Vector:
    """The vector a multiplied by a factor."""
    return factor * a[0], factor * a[1], factor * a[2]


def moved(a: Vector, factor: Number, b: Vector) -> Vector:
    """The vector a + factor b, component by component."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


def dot(a: Vector, b: Vector) -> Number:
    """The dot product a . b of two vectors (3)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def rejection(a: Vector, b: Vector) -> Vector:
    """The component a - (a . b) b/|b|^2 of a vector a that is perpendicular to b != 0."""
    length = hypot(*b)
    direction = times(1 / length, b)
    return moved(a, -dot(a, direction), direction)


def cross(a: Vector, b: Vector) -> Vector:
    """The cross product a x b of two vectors (3)."""
    ax, ay, az = a
    bx, by, bz = b
    x = ay * bz - az * by
    y = az * bx - ax * bz
    z = ax * by - ay * bx
    return x, y, z


def size(a: Vector) -> Number:
    """The length |a| of a vector (3)."""
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


def per_axis(a: Vector, b: Vector) -> Vector:
    """Products component by component."""
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


def over_axis(a: Vector, b: Vector) -> Vector:
    """Quotients component by component."""
    return a[0] / b[0], a[1] / b[1], a[2] / b[2]


def conjugate(q: Quaternion) -> Quaternion:
    """The conjugate q* of a quaternion (4)."""
    return q[0], -q[1], -q[2], -q[3]


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """The product p q of two quaternions (4)."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    # (p, a)(q, b) = (p q - a . b, p b + q a + a x b), Hamilton 1843.
    w = pw * qw - px * qx - py * qy - pz * qz
    x = pw * qx + px * qw + py * qz - pz * qy
    y = pw * qy + py * qw + pz * qx - px * qz
    z = pw * qz + pz * qw + px * qy - py * qx
    return w, x, y, z


def moved_turn(q: Quaternion, factor: Number, rate: Quaternion) -> Quaternion:
    """q + factor rate, which is not normalised."""
    w = q[0] + factor * rate[0]
    x = q[1] + factor * rate[1]
    y = q[2] + factor * rate[2]
    z = q[3] + factor * rate[3]
    return w, x, y, z


def rotated(q: Quaternion, v: Vector) -> Vector:
    """The vector v rotated by the quaternion q: q v q*."""
    # q v q* = v + w s + u x s with s = 2 u x v, for q = (w, u).
    axis = (q[1], q[2], q[3])
    twist = times(2.0, cross(axis, v))
    return plus(moved(v, q[0], twist), cross(axis, twist))


def turn_by(angles: Vector) -> Quaternion:
    """The rotation by |angles| [rad] about the vector `angles`: (cos(a/2), sin(a/2) angles/a), a =
    |angles|.
    """
    angle = size(angles)
    if not angle > 0:
        return 1.0, 0.0, 0.0, 0.0
    # sin(a/2)/a, the factor of `angles` in the vector part.
    half = sin(angle / 2) / angle
    return cos(angle / 2), half * angles[0], half * angles[1], half * angles[2]


def unit(q: Quaternion) -> Quaternion:
    """The unit quaternion q / |q|."""
    w, x, y, z = q
    norm = sqrt(w * w + x * x + y * y + z * z)
    return w / norm, x / norm, y / norm, z / norm
