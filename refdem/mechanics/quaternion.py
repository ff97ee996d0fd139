"""Quaternions (w, x, y, z), unit ones rotating body vectors into space: r_s = q r_b q*."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def product(p: Array, q: Array) -> Array:
    """The quaternion product p q, (..., 4); it does not commute."""
    p = np.asarray(p, float)
    q = np.asarray(q, float)
    w = p[..., :1] * q[..., :1] - np.sum(p[..., 1:] * q[..., 1:], axis=-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, v], axis=-1)


def conjugate(q: Array) -> Array:
    """The conjugate (w, -x, -y, -z), (..., 4); of a unit quaternion the inverse."""
    return np.asarray(q, float) * np.array([1.0, -1.0, -1.0, -1.0])


def rotated(q: Array, v: Array) -> Array:
    """The vector q v q*, (..., 3), for unit q (..., 4)."""
    q = np.asarray(q, float)
    v = np.asarray(v, float)
    twist = 2.0 * np.cross(q[..., 1:], v)
    return v + q[..., :1] * twist + np.cross(q[..., 1:], twist)


def angle_between(p: Array, q: Array) -> Array:
    """Angle (...,) [rad] in [0, pi] of the rotation that takes attitude q to attitude p; q and -q
    are the same attitude.

    `2 atan2(|vector part|, |scalar part|)` of p q*: accurate for small angles, where arccos is not.
    """
    relative = product(p, conjugate(q))
    return 2.0 * np.arctan2(np.linalg.norm(relative[..., 1:], axis=-1), np.abs(relative[..., 0]))


def matrix(q: Array) -> Array:
    """The rotation matrix R(q) (..., 3, 3) that maps body vectors to space, for unit q (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
