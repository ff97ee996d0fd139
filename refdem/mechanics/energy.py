"""Kinetic energy of rigid bodies, T = (sum m v.v + sum J_k omega_k^2)/2 with omega in body axes,
and its parts by degree of freedom.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.quaternion import conjugate, rotated

Array = NDArray[np.float64]


def kinetic(mass: Array, inertia: Array, velocity: Array, attitude: Array, omega: Array) -> Array:
    """Kinetic energy (T,) [J] of translation and rotation.

    mass (N,) [kg], principal inertia (N, 3) [kg m^2], velocity (T, N, 3) [m/s], attitude (T, N, 4),
    omega (T, N, 3) [rad/s] in space axes.
    """
    omega_body = rotated(conjugate(attitude), omega)
    translation = np.einsum("n,tnk,tnk->t", mass, velocity, velocity)
    rotation = np.einsum("nk,tnk,tnk->t", inertia, omega_body, omega_body)
    energy: Array = 0.5 * (translation + rotation)
    return energy


def kinetic_parts(
    mass: Array, inertia: Array, velocity: Array, attitude: Array, omega: Array
) -> Array:
    """The parts (T, N, 6) [J] of the kinetic energy of every body: of translation along each axis
    of space, m v_k^2/2, and of rotation about each principal axis, J_k omega_k^2/2.

    For a body with equal moments, all of whose axes are principal, the axes of space are used. The
    arguments are those of `kinetic`.
    """
    omega_body = rotated(conjugate(attitude), omega)
    is_isotropic = np.ptp(inertia, axis=1) == 0
    omega_body[:, is_isotropic] = omega[:, is_isotropic]
    translation = mass[:, None] * velocity**2
    rotation = inertia * omega_body**2
    parts: Array = 0.5 * np.concatenate([translation, rotation], axis=2)
    return parts
