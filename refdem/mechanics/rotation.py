"""Rotation matrices and Euler angles z-x-z, and their conversion from and to quaternions (chapter
1, (1.9) to (1.79)).

Every matrix here maps body vectors to space (the transpose of the chapter's (1.21)).
"""

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.quaternion import product

Array = NDArray[np.float64]


def about_axis(axis: int, angle: float) -> Array:
    """The rotation matrix (3, 3) by `angle` [rad] about x, y or z (0, 1, 2), counter-clockwise seen
    from the tip of the axis.
    """
    turn = np.eye(3)
    # i and j are the other two axes, with (axis, i, j) right-handed: R_ii = R_jj = cos(angle),
    # R_ji = -R_ij = sin(angle).
    i = (axis + 1) % 3
    j = (axis + 2) % 3
    turn[i, i] = np.cos(angle)
    turn[j, j] = turn[i, i]
    turn[j, i] = np.sin(angle)
    turn[i, j] = -turn[j, i]
    return turn


def about_axis_quaternion(axis: Array, angle: float) -> Array:
    """The unit quaternion (cos(angle/2), sin(angle/2) n) (4,) of a rotation by `angle` [rad] about
    the unit vector n = `axis` (3,) (1.64).
    """
    scalar = np.cos(angle / 2)
    vector = np.sin(angle / 2) * np.asarray(axis, float)
    return np.concatenate([[scalar], vector])


def quaternion_of_matrix(turn: Array) -> Array:
    """The unit quaternion (4,), w >= 0, of a rotation matrix R (3, 3).

    R gives 4 q_i q_j for all pairs of components. The row of the largest component is taken and
    normalised, so that nothing is divided by a small number (Shepperd 1978).
    """
    # 4 w^2 = 1 + trace, and 4 x^2 = 1 + 2 R_xx - trace: |w|, |x|, |y|, |z| are ordered as trace,
    # R_xx, R_yy, R_zz are.
    trace = np.trace(turn)
    ordering = np.array([trace, *np.diag(turn)])
    largest = int(np.argmax(ordering))
    # R - R^T holds 4 w (x, y, z).
    skew_x = turn[2, 1] - turn[1, 2]
    skew_y = turn[0, 2] - turn[2, 0]
    skew_z = turn[1, 0] - turn[0, 1]
    skew = np.array([skew_x, skew_y, skew_z])
    if largest == 0:
        q = np.concatenate([[1 + trace], skew])
    else:
        # 4 x (w, x, y, z), if x is the largest: R_xy + R_yx = 4 x y.
        i = largest - 1
        q = np.concatenate([[skew[i]], turn[i] + turn[:, i]])
        q[largest] = 1 + 2 * turn[i, i] - trace
    q /= np.linalg.norm(q)
    if q[0] < 0:
        return -q
    return q


def matrix_of_euler(phi: float, theta: float, psi: float) -> Array:
    """Rz(phi) Rx(theta) Rz(psi) (3, 3), from body to space."""
    return about_axis(2, phi) @ about_axis(0, theta) @ about_axis(2, psi)


def quaternion_of_euler(phi: float, theta: float, psi: float) -> Array:
    """The unit quaternion (4,) of Euler angles z-x-z (1.76) to (1.79); its w may be negative."""
    # (cos(phi/2), 0, 0, sin(phi/2)) (cos(theta/2), sin(theta/2), 0, 0) (cos(psi/2), 0, 0,
    # sin(psi/2)), with the sums of products as cosines and sines of (phi +- psi)/2.
    c = np.cos(theta / 2)
    s = np.sin(theta / 2)
    half_sum = (phi + psi) / 2
    half_difference = (phi - psi) / 2
    w = c * np.cos(half_sum)
    x = s * np.cos(half_difference)
    y = s * np.sin(half_difference)
    z = c * np.sin(half_sum)
    return np.array([w, x, y, z])


def euler_of_matrix(turn: Array) -> Array:
    """Euler angles phi, theta, psi (3,) [rad], theta in [0, pi], of a rotation matrix; psi is 0
    where sin theta = 0.
    """
    # R = Rz(phi) Rx(theta) Rz(psi) has the third column (sin phi sin theta, -cos phi sin theta,
    # cos theta) and the third row (sin theta sin psi, sin theta cos psi, cos theta).
    sine = np.hypot(turn[0, 2], turn[1, 2])
    theta = np.arctan2(sine, turn[2, 2])
    if sine == 0:
        # The matrix depends only on phi + psi (theta = 0) or phi - psi (theta = pi) there.
        phi = np.arctan2(turn[1, 0], turn[0, 0])
        return np.array([phi, theta, 0.0])
    phi = np.arctan2(turn[0, 2], -turn[1, 2])
    psi = np.arctan2(turn[2, 0], turn[2, 1])
    return np.array([phi, theta, psi])


def euler_rates(phi: float, theta: float, omega: Array) -> Array:
    """phi', theta', psi' (3,) [rad/s] for omega (3,) in space axes (1.39) to (1.41); they diverge
    where sin theta = 0.
    """
    x, y, z = omega
    # omega along the line of nodes (cos phi, sin phi, 0), and along (sin phi, -cos phi, 0):
    # phi' = z - across/tan(theta), theta' = along, psi' = across/sin(theta).
    along = x * np.cos(phi) + y * np.sin(phi)
    across = x * np.sin(phi) - y * np.cos(phi)
    phi_rate = z - across / np.tan(theta)
    psi_rate = across / np.sin(theta)
    return np.array([phi_rate, along, psi_rate])


def euler_rate_matrix(phi: float, theta: float) -> Array:
    """The matrix (3, 3) that takes the rates of Euler angles to omega in space axes: its columns
    are the axes of the three rotations: z, the line of nodes, and the body's third axis.
    """
    nodes = [np.cos(phi), np.sin(phi), 0.0]
    third = [np.sin(phi) * np.sin(theta), -np.cos(phi) * np.sin(theta), np.cos(theta)]
    return np.column_stack([[0.0, 0.0, 1.0], nodes, third])


def euler_rate_inverse(phi: float, theta: float) -> Array:
    """The matrix (3, 3) that takes omega in space axes to the rates of Euler angles (1.39) to
    (1.41): its columns are the rates at omega = e_x, e_y and e_z.
    """
    return np.column_stack([euler_rates(phi, theta, axis) for axis in np.eye(3)])


def quaternion_rate(q: Array, omega: Array) -> Array:
    """q' = (0, omega) q/2 (4,) [1/s], for omega (3,) in space axes (1.67): regular at every
    attitude.
    """
    return product(np.concatenate([[0.0], omega]), q) / 2


def cross_matrix(v: Array) -> Array:
    """The matrix [v] (3, 3) of the cross product with a vector (3,): [v] r = v x r."""
    x, y, z = v
    rows = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    return np.array(rows)


def first_order_turn(turn: Array, v: Array) -> Array:
    """(1 + [v]) M (3, 3): a step of Euler's method for M' = [omega] M, with the rotation vector v =
    h omega (3,) [rad].
    """
    return turn + cross_matrix(v) @ turn


def orthogonality(turn: Array) -> Array:
    """M^T M - 1 (3, 3), which is zero for an orthogonal matrix M."""
    return turn.T @ turn - np.eye(3)


def nearest_turn(turn: Array) -> Array:
    """The rotation matrix (3, 3) nearest to a matrix with a positive determinant: U V^T of its
    singular value decomposition U S V^T.
    """
    u, _, v_transposed = np.linalg.svd(turn)
    nearest: Array = u @ v_transposed
    return nearest


def pauli_matrix(v: Array) -> NDArray[np.complex128]:
    """x s1 + y s2 + z s3 (2, 2) with Pauli's matrices (1.143), for v = (x, y, z)."""
    x, y, z = v
    rows = [[z, x - 1j * y], [x + 1j * y, -z]]
    return np.array(rows)


def real_matrix(q: Array) -> Array:
    """The matrix (4, 4) of multiplication from the left by q (1.57)."""
    w, x, y, z = q
    rows = [
        [w, -x, -y, -z],
        [x, w, -z, y],
        [y, z, w, -x],
        [z, -y, x, w],
    ]
    return np.array(rows)


def complex_matrix(q: Array) -> NDArray[np.complex128]:
    """The matrix w 1 - i (x s1 + y s2 + z s3) (2, 2) with Pauli's matrices s: their products are
    those of quaternions.
    """
    w, x, y, z = q
    rows = [
        [w - 1j * z, -y - 1j * x],
        [y - 1j * x, w + 1j * z],
    ]
    return np.array(rows)
