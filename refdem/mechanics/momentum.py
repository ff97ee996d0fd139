"""Momentum and angular momentum of rigid bodies, about the space origin."""

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.quaternion import conjugate, rotated

Array = NDArray[np.float64]


def linear(mass: Array, velocity: Array) -> Array:
    """Momentum sum m v (T, 3) [kg m/s] for mass (N,), velocity (T, N, 3)."""
    momentum: Array = np.einsum("n,tnk->tk", mass, velocity)
    return momentum


def orbital(mass: Array, position: Array, velocity: Array) -> Array:
    """Orbital angular momentum sum m r x v (T, 3) [kg m^2/s]; mass (N,), position and velocity (T,
    N, 3).
    """
    momentum: Array = np.einsum("n,tnk->tk", mass, np.cross(position, velocity))
    return momentum


def spin(inertia: Array, attitude: Array, omega: Array) -> Array:
    """Spin angular momentum sum R J R^T omega (T, 3) [kg m^2/s].

    Principal inertia J (N, 3), attitude (T, N, 4) as rotation R from body axes to space, omega (T,
    N, 3) in space axes.
    """
    of_each = rotated(attitude, inertia * rotated(conjugate(attitude), omega))
    momentum: Array = of_each.sum(axis=1)
    return momentum
