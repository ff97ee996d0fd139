"""Kinetic energy and angular momentum of points, split by Koenig's theorem into those of the centre
of mass and those about it, and the rotational energy by the inertia tensor.

    T = M V^2/2 + sum m |v - V|^2/2,   L = M R x V + sum m (r - R) x (v - V).

Masses are (N,) [kg], positions (N, 3) [m] and velocities (N, 3) [m/s].
"""

import numpy as np
from numpy.typing import NDArray

from refdem.mechanics.mass_properties import of_points

Array = NDArray[np.float64]


def mean(mass: Array, vectors: Array) -> Array:
    """The mean (3,) of vectors (N, 3) with the masses as weights: the centre of mass of positions,
    its velocity of velocities.
    """
    weighted: Array = mass @ vectors
    return weighted / np.sum(mass)


def energy(mass: Array, velocity: Array) -> float:
    """The kinetic energy sum m v^2/2 [J] of the points."""
    return 0.5 * float(np.sum(mass * np.sum(velocity**2, axis=1)))


def energy_of_centre(mass: Array, velocity: Array) -> float:
    """The kinetic energy M V^2/2 [J] of all mass at the velocity V of the centre of mass."""
    drift = mean(mass, velocity)
    return 0.5 * float(np.sum(mass) * (drift @ drift))


def energy_about_centre(mass: Array, velocity: Array) -> float:
    """The kinetic energy sum m |v - V|^2/2 [J] about the centre of mass."""
    return energy(mass, velocity - mean(mass, velocity))


def angular_momentum(mass: Array, position: Array, velocity: Array) -> Array:
    """The angular momentum sum m r x v (3,) [kg m^2/s] about the origin."""
    momentum: Array = mass @ np.cross(position, velocity)
    return momentum


def angular_momentum_of_centre(mass: Array, position: Array, velocity: Array) -> Array:
    """The angular momentum M R x V (3,) [kg m^2/s] of all mass in the centre of mass."""
    momentum: Array = np.sum(mass) * np.cross(mean(mass, position), mean(mass, velocity))
    return momentum


def angular_momentum_about_centre(mass: Array, position: Array, velocity: Array) -> Array:
    """The angular momentum sum m (r - R) x (v - V) (3,) [kg m^2/s] about the centre of mass."""
    arm = position - mean(mass, position)
    return angular_momentum(mass, arm, velocity - mean(mass, velocity))


def swept_energy(mass: Array, position: Array, omega: Array) -> float:
    """The kinetic energy sum m |omega x r|^2/2 [J] of points that rotate about the origin with
    omega (3,) [rad/s].
    """
    return energy(mass, np.cross(omega, position))


def tensor_energy(mass: Array, position: Array, omega: Array) -> float:
    """The kinetic energy omega . J omega/2 [J] of the same points by their tensor of inertia J
    about the origin (1.24).
    """
    inertia = of_points(mass, position).about(np.zeros(3))
    return 0.5 * float(omega @ inertia @ omega)
