"""Quaternions q = (w, x, y, z) = (w, u); unit ones rotate body vectors into space, r_s = q r_b
q*.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def product(p: Array, q: Array) -> Array:
    """The quaternion product p q (..., 4): (a, u)(b, v) = (a b - u.v, a v + b u + u x v)."""
    p = np.asarray(p, float)
    q = np.asarray(q, float)
    p_scalar = p[..., :1]
    p_vector = p[..., 1:]
    q_scalar = q[..., :1]
    q_vector = q[..., 1:]
    scalar = p_scalar * q_scalar - np.sum(p_vector * q_vector, axis=-1, keepdims=True)
    vector = p_scalar * q_vector + q_scalar * p_vector + _cross(p_vector, q_vector)
    return np.concatenate([scalar, vector], axis=-1)


def conjugate(q: Array) -> Array:
    """The conjugate (w, -x, -y, -z) (..., 4), which is the inverse of a unit quaternion."""
    result: Array = np.asarray(q, float) * np.array([1.0, -1.0, -1.0, -1.0])
    return result


def rotated(q: Array, v: Array) -> Array:
    """The rotated vector q v q* (..., 3), for unit q (..., 4)."""
    q = np.asarray(q, float)
    v = np.asarray(v, float)
    scalar = q[..., :1]
    vector = q[..., 1:]
    # q v q* = v + w s + u x s with s = 2 u x v, for q = (w, u).
    twist = 2.0 * _cross(vector, v)
    return v + scalar * twist + _cross(vector, twist)


def angle_between(p: Array, q: Array) -> Array:
    """Angle (...,) [rad] in [0, pi] of the rotation from attitude q to attitude p; q and -q are the
    same attitude.

    It is 2 atan2(|vector part|, |scalar part|) of p q*, which is accurate for small angles, where
    arccos is not.
    """
    # p q* = +-(cos(a/2), n sin(a/2)).
    relative = product(p, conjugate(q))
    sine = np.linalg.norm(relative[..., 1:], axis=-1)
    cosine = np.abs(relative[..., 0])
    angle: Array = 2.0 * np.arctan2(sine, cosine)
    return angle


def turned_by(turn: Array) -> Array:
    """The quaternions (..., 4) of rotations by the angle |turn| [rad] about `turn` (..., 3).

    They are (cos(|turn|/2), sin(|turn|/2) turn/|turn|), and 1 where `turn` is 0.
    """
    half = np.linalg.norm(turn, axis=-1, keepdims=True) / 2.0
    # np.sinc(x) is sin(pi x)/(pi x), and 1 at 0.
    quaternion: Array = np.concatenate([np.cos(half), np.sinc(half / np.pi) * turn / 2.0], axis=-1)
    return quaternion


def matrix(q: Array) -> Array:
    """The rotation matrix R(q) (..., 3, 3) from body vectors to space, for unit q (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    # Rows of R = 1 + 2 w [u] + 2 [u]^2, with [u] the matrix of the cross product u x.
    x_row = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
    y_row = [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
    z_row = [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    rows = [np.stack(row, axis=-1) for row in (x_row, y_row, z_row)]
    return np.stack(rows, axis=-2)


def _cross(u: Array, v: Array) -> Array:
    """u x v (..., 3), with the same bits as np.cross, but faster for small arrays."""
    u_x = u[..., 0]
    u_y = u[..., 1]
    u_z = u[..., 2]
    v_x = v[..., 0]
    v_y = v[..., 1]
    v_z = v[..., 2]
    crossed = np.empty(np.broadcast_shapes(u.shape, v.shape))
    crossed[..., 0] = u_y * v_z - u_z * v_y
    crossed[..., 1] = u_z * v_x - u_x * v_z
    crossed[..., 2] = u_x * v_y - u_y * v_x
    return crossed
