"""Kinetic energy of rigid bodies."""

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.quaternion import conjugate, rotated

Array = NDArray[np.float64]


def kinetic(mass: Array, inertia: Array, velocity: Array, attitude: Array, omega: Array) -> Array:
    """Kinetic energy (T,) [J], translation and rotation.

    mass (N,) [kg], principal inertia (N, 3) [kg m^2], velocity (T, N, 3) [m/s], attitude (T, N, 4),
    omega (T, N, 3) [rad/s] in space axes.
    """
    body_omega = rotated(conjugate(attitude), omega)
    # T = (sum m v.v + sum J_k omega_k^2)/2, omega in body axes.
    of_flight = np.einsum("n,tnk,tnk->t", mass, velocity, velocity)
    of_spin = np.einsum("nk,tnk,tnk->t", inertia, body_omega, body_omega)
    energy: Array = 0.5 * (of_flight + of_spin)
    return energy
